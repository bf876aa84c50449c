// Whether foreign viewers show a room of known light within 1%: node check.mjs
//
// The exit status is 0 if they do, 1 if not, and 77 if something is not installed.

import { spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { exr, expectation, glb } from "./room.mjs";
import { MISSING } from "./common.mjs";

// What is run, and how far off it may be: 8-bit texels and those of an EXR.
const RUNS = [
    ["three.mjs", [], 0.01],
    ["three.mjs", ["--material", "lambert"], 0.01],
    ["three.mjs", ["--exr", "light.exr"], 0.003],
    ["babylon.mjs", [], 0.01],
    ["babylon.mjs", ["--exr", "light.exr"], 0.003],
];

const here = dirname(fileURLToPath(import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "azulejo-viewers-"));
const { camera, points, radiance } = expectation();
writeFileSync(join(folder, "room.glb"), glb());
writeFileSync(join(folder, "light.exr"), exr());
writeFileSync(join(folder, "camera.json"), JSON.stringify(camera));
writeFileSync(join(folder, "points.json"), JSON.stringify(points));
let status = 0;
for (const [script, options, tolerance] of RUNS) {
    const run = spawnSync("node", [join(here, script), "room.glb", "camera.json", "points.json", ...options],
        { cwd: folder, encoding: "utf8", timeout: 120000 });
    const name = [script, ...options].join(" ");
    if (run.status !== 0) {
        console.log(`${name}: ${run.stderr}`);
        status = run.status === MISSING ? MISSING : 1;
        break;
    }
    const pixels = JSON.parse(run.stdout);
    const off = (value, meant) => (meant === 0 ? value : Math.abs(value / meant - 1));
    const difference = (pixel, k) => Math.max(...pixel.map((value, c) => off(value, radiance[k][c])));
    const differences = pixels.map(difference);
    const worst = differences.indexOf(Math.max(...differences));
    const isGood = pixels.length === points.length && differences[worst] <= tolerance;
    console.log(`${name}: ${points.length} points, largest difference ${(100 * differences[worst]).toFixed(3)}%` +
        (isGood ? "" : ` at ${points[worst]}: ${pixels[worst]}, expected ${radiance[worst]}`));
    status = isGood ? status : 1;
}
rmSync(folder, { recursive: true, force: true });
process.exit(status);
