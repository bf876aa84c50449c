// Linear pixels of a model in Babylon.js: node babylon.mjs MODEL.glb CAMERA.json POINTS.json > pixels.json
//
// CAMERA is { eye, target, up, vertical_fov, width, height } with degrees, POINTS is [[x, y], …] in pixels from the
// upper left; what is printed is [[r, g, b], …]. --exr LIGHT.exr takes the light from that file, --picture OUT.png makes a
// picture for people as well. Needs the folder AZULEJO_VIEWERS with the npm packages babylonjs and babylonjs-loaders, and Chromium.

import { view } from "./common.mjs";

await view("babylon.html", "babylonjs-loaders");
