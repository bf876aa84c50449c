// Linear pixels of a matt ball in the light of a grid in three.js: node probes.mjs VOLUME.json CAMERA.json POINTS.json
//
// The ball has the radius 0.25 and the reflectance 0.5, and is where the camera looks. Otherwise as three.mjs.

import { view } from "./common.mjs";

await view("probes.html", "three");
