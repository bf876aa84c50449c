// A matt ball in the light of `azulejo probe --grid -o volume.json`.

import * as THREE from "three";
import { LightProbeGridWebGL } from "three/addons/lighting/LightProbeGridWebGL.js";

// The grid of a volume, as docs/probes.md has it.
function gridOf(v) {
    const [nx, ny, nz] = v.resolution, size = v.max.map((high, k) => high - v.min[k]);
    const grid = new LightProbeGridWebGL(...size, nx, ny, nz);
    grid.position.set(...v.max.map((high, k) => (high + v.min[k]) / 2));
    const texels = new Float32Array(4 * nx * ny * 7 * (nz + 2));
    for (let part = 0; part < 7; part++) for (let z = -1; z <= nz; z++) for (let p = 0; p < nx * ny; p++) {
        const probe = Math.min(Math.max(z, 0), nz - 1) * nx * ny + p;
        const at = 4 * ((part * (nz + 2) + z + 1) * nx * ny + p);
        for (let k = 4 * part; k < Math.min(4 * part + 4, 27); k++) texels[at + k % 4] = v.coefficients[27 * probe + k];
    }
    grid.texture = new THREE.Data3DTexture(texels, nx, ny, 7 * (nz + 2));
    Object.assign(grid.texture, { format: THREE.RGBAFormat, type: THREE.FloatType, needsUpdate: true,
        minFilter: THREE.LinearFilter, magFilter: THREE.LinearFilter });
    grid.updateBoundingBox();
    return grid;
}

window.show = async ({ model, camera, points }) => {
    const { width, height } = camera;
    const volume = await (await fetch(model)).json();
    const scene = new THREE.Scene();
    scene.add(gridOf(volume));
    const ball = new THREE.Mesh(new THREE.SphereGeometry(0.25, 64, 32), new THREE.MeshLambertMaterial());
    ball.material.color.setRGB(0.5, 0.5, 0.5, THREE.LinearSRGBColorSpace);
    ball.position.set(...camera.target);
    scene.add(ball);
    const view = new THREE.PerspectiveCamera(camera.vertical_fov, width / height, 0.1, 100);
    view.position.set(...camera.eye);
    view.up.set(...camera.up);
    view.lookAt(...camera.target);
    const renderer = new THREE.WebGLRenderer();
    renderer.setSize(width, height);
    const target = new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType });
    renderer.setRenderTarget(target);
    renderer.render(scene, view);
    const numbers = new Float32Array(4 * width * height);
    renderer.readRenderTargetPixels(target, 0, 0, width, height, numbers);
    return { pixels: pixelsAt(numbers, width, height, points) };
};
