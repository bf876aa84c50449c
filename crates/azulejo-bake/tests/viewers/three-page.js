// A model with MOZ_lightmap in three.js.

import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { EXRLoader } from "three/addons/loaders/EXRLoader.js";
import { KTX2Loader } from "three/addons/loaders/KTX2Loader.js";

// The plugin: lightmaps of all materials, unlit ones included.
class LightmapPlugin {
    constructor(parser) {
        this.parser = parser;
        this.name = "MOZ_lightmap";
    }

    async afterRoot(result) {
        const materials = new Set();
        result.scenes.forEach((scene) => scene.traverse((node) => node.material && materials.add(node.material)));
        await Promise.all([...materials].map((material) => this.apply(material)));
    }

    async apply(material) {
        const { json, associations } = this.parser;
        const definition = json.materials?.[associations.get(material)?.materials]?.extensions?.MOZ_lightmap;
        if (!definition) {
            return;
        }
        const info = { texCoord: 1, ...definition };
        await this.parser.assignTexture(material, "lightMap", info, THREE.SRGBColorSpace);
        // three divides by π for unlit materials as well, where the extension does not.
        const factor = material.isMeshBasicMaterial ? Math.PI : 1;
        material.lightMapIntensity = (definition.intensity ?? 1) * factor;
        material.needsUpdate = true;
    }
}

// The light of an EXR beside the model: values as they are, rows from the top.
async function useExr(scene, address) {
    const light = await new EXRLoader().loadAsync(address);
    light.flipY = true;
    light.minFilter = light.magFilter = THREE.LinearFilter;
    light.generateMipmaps = false;
    const done = new Set();
    scene.traverse(({ material }) => {
        if (material?.lightMap && !done.has(material)) {
            done.add(material);
            const texture = light.clone();
            const { channel, offset, repeat, rotation } = material.lightMap;
            Object.assign(texture, { channel, rotation, needsUpdate: true });
            texture.offset.copy(offset);
            texture.repeat.copy(repeat);
            material.lightMap = texture;
            material.lightMapIntensity = material.isMeshBasicMaterial ? Math.PI : 1;
        }
    });
}

// Matt materials without the specular share that MeshStandardMaterial takes from the light.
function useLambert(scene) {
    scene.traverse((node) => {
        if (node.material?.isMeshStandardMaterial) {
            const { color, map, lightMap, lightMapIntensity, emissive, emissiveMap, emissiveIntensity, side, alphaTest,
                transparent, opacity, vertexColors } = node.material;
            node.material = new THREE.MeshLambertMaterial({ color, map, lightMap, lightMapIntensity, emissive, emissiveMap,
                emissiveIntensity, side, alphaTest, transparent, opacity, vertexColors });
        }
    });
}

window.show = async ({ model, camera, points, exr, tone, exposure, material }) => {
    const { width, height } = camera;
    const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    const loader = new GLTFLoader().register((parser) => new LightmapPlugin(parser));
    loader.setKTX2Loader(new KTX2Loader().detectSupport(renderer));
    const gltf = await loader.loadAsync(model);
    if (exr) {
        await useExr(gltf.scene, exr);
    }
    if (material === "lambert") {
        useLambert(gltf.scene);
    }
    const size = new THREE.Box3().setFromObject(gltf.scene).getBoundingSphere(new THREE.Sphere());
    const eye = new THREE.Vector3(...camera.eye);
    const far = eye.distanceTo(size.center) + size.radius;
    const view = new THREE.PerspectiveCamera(camera.vertical_fov, width / height, far * 2e-4, far * 1.01);
    view.position.copy(eye);
    view.up.set(...camera.up);
    view.lookAt(...camera.target);
    const scene = new THREE.Scene();
    scene.add(gltf.scene);

    renderer.setSize(width, height);
    document.body.appendChild(renderer.domElement);
    renderer.toneMapping = THREE.NoToneMapping;
    const target = new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType, minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter });
    renderer.setRenderTarget(target);
    renderer.render(scene, view);
    const numbers = new Float32Array(4 * width * height);
    renderer.readRenderTargetPixels(target, 0, 0, width, height, numbers);
    const pixels = pixelsAt(numbers, width, height, points);
    if (!tone) {
        return { pixels };
    }
    renderer.setRenderTarget(null);
    renderer.toneMapping = tone === "linear" ? THREE.LinearToneMapping : THREE.ACESFilmicToneMapping;
    renderer.toneMappingExposure = exposure ?? exposureOf(numbers);
    scene.traverse((node) => node.material && (node.material.needsUpdate = true));
    renderer.render(scene, view);
    return { pixels, picture: renderer.domElement.toDataURL("image/png") };
};
