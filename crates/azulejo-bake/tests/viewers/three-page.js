// A model with MOZ_lightmap in three.js.

import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { EXRLoader } from "three/addons/loaders/EXRLoader.js";
import { KTX2Loader } from "three/addons/loaders/KTX2Loader.js";
import { LightmapPlugin } from "/azulejo-lightmap/index.js";

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
    const light = exr && (await new EXRLoader().loadAsync(exr));
    const loader = new GLTFLoader().register((parser) => new LightmapPlugin(parser, { exr: light }));
    loader.setKTX2Loader(new KTX2Loader().detectSupport(renderer));
    const gltf = await loader.loadAsync(model);
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
