// A model with MOZ_lightmap in Babylon.js.

import { registerLightmaps } from "/azulejo-lightmap/index.js";

// Babylon cuts linear colours at 30, so what is read as numbers is drawn darker by this power of 2.
const DIMMED = 2 ** -20;

// What decompresses EXR comes from a public host otherwise.
BABYLON.ExrLoaderGlobalConfiguration.FFLATEUrl = "/packages/fflate/umd/index.js";

// Multiplies everything that shines by a factor.
function dim(scene, factor) {
    const done = new Set();
    const scale = (object, property) => {
        if (object && !done.has(object)) {
            done.add(object);
            object[property] *= factor;
        }
    };
    for (const material of scene.materials) {
        scale(material, "emissiveIntensity");
        scale(material.lightmapTexture, "level");
        if (material.unlit && !material.lightmapTexture) {
            material.albedoColor.scaleToRef(factor, material.albedoColor);
        }
    }
    scene.lights.forEach((light) => scale(light, "intensity"));
}

window.show = async ({ model, camera, points, exr, tone, exposure }) => {
    registerLightmaps(BABYLON.GLTF2.GLTFLoader, { exr, MaterialPluginBase: BABYLON.MaterialPluginBase });
    const { width, height } = camera;
    const canvas = document.getElementById("canvas");
    const engine = new BABYLON.Engine(canvas, true, { preserveDrawingBuffer: true, useExactSrgbConversions: true });
    engine.setSize(width, height);
    const scene = new BABYLON.Scene(engine);
    scene.useRightHandedSystem = true;
    scene.clearColor = new BABYLON.Color4(0, 0, 0, 1);
    // Materials leave light linear; a post-process would tone-map it.
    scene.imageProcessingConfiguration.applyByPostProcess = true;
    await BABYLON.AppendSceneAsync(model, scene, { pluginExtension: model.endsWith(".gltf") ? ".gltf" : ".glb" });
    const view = new BABYLON.FreeCamera("view", new BABYLON.Vector3(...camera.eye), scene);
    view.upVector = new BABYLON.Vector3(...camera.up);
    view.setTarget(new BABYLON.Vector3(...camera.target));
    view.fov = (camera.vertical_fov * Math.PI) / 180;
    const { min, max } = scene.getWorldExtends();
    const far = BABYLON.Vector3.Distance(view.position, min.add(max).scale(0.5)) + max.subtract(min).length() / 2;
    [view.minZ, view.maxZ] = [far * 2e-4, far * 1.01];
    scene.activeCamera = view;
    await scene.whenReadyAsync();

    const target = new BABYLON.RenderTargetTexture("target", { width, height }, scene, false, true,
        BABYLON.Constants.TEXTURETYPE_FLOAT, false, BABYLON.Texture.NEAREST_SAMPLINGMODE);
    target.activeCamera = view;
    target.renderList = scene.meshes;
    target.clearColor = new BABYLON.Color4(0, 0, 0, 1);
    // The shaders for this target may be others, and are made in the background.
    for (let k = 0; k < 200 && !target.isReadyForRendering(); k++) {
        await new Promise((done) => setTimeout(done, 10));
    }
    dim(scene, DIMMED);
    target.render();
    const numbers = (await target.readPixels()).map((x) => x / DIMMED);
    dim(scene, 1 / DIMMED);
    const pixels = pixelsAt(numbers, width, height, points);
    if (!tone) {
        return { pixels };
    }
    const processing = scene.imageProcessingConfiguration;
    processing.applyByPostProcess = false;
    processing.toneMappingEnabled = tone !== "linear";
    processing.toneMappingType = BABYLON.ImageProcessingConfiguration.TONEMAPPING_ACES;
    processing.exposure = exposure ?? exposureOf(numbers);
    await scene.whenReadyAsync();
    scene.render();
    return { pixels, picture: canvas.toDataURL("image/png") };
};
