// Uses the page in headless Chromium, as users do and by the words of its scripts.
//
// node page.mjs FOLDER EXPECTED WORKSPACE [SHOTS]: FOLDER is what the tool makes; EXPECTED has results of the desktop, by the
// names of scenes in examples/ and of `bits`; screenshots are written to SHOTS.
import { Browser, findChromium } from "../../azulejo-bake/tests/browser/chromium.mjs";
import assert from "node:assert/strict";
import { existsSync, mkdirSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { extname, join, normalize } from "node:path";

const [folder, expected, workspace, shots] = process.argv.slice(2);
if (!existsSync(join(folder, "azulejo_web_bg.wasm"))) {
    console.error(`no page in ${folder}: make it by cargo run --release --manifest-path crates/azulejo-web/tool/Cargo.toml`);
    process.exit(77);
}
const program = findChromium();
if (!program) {
    console.error("no Chromium: apt install chromium, or set AZULEJO_CHROMIUM");
    process.exit(77);
}
if (shots) mkdirSync(shots, { recursive: true });

const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm" };
const server = createServer((request, response) => {
    const path = normalize(new URL(request.url, "http://localhost").pathname);
    const file = join(folder, path === "/" ? "index.html" : path);
    if (!existsSync(file)) return response.writeHead(404).end();
    response.writeHead(200, { "content-type": TYPES[extname(file)] ?? "application/octet-stream" });
    response.end(readFileSync(file));
});
await new Promise((done) => server.listen(0, "127.0.0.1", done));
const host = `http://127.0.0.1:${server.address().port}`;
const browser = new Browser(program);
const timings = {};

async function open(query = "") {
    await browser.open(`${host}/${query}`);
    for (let k = 0; k < 600 && !(await browser.evaluate("globalThis.azulejo?.started")); k++) {
        await new Promise((done) => setTimeout(done, 100));
    }
    return browser.evaluate("azulejo.started");
}
const state = () => browser.evaluate("azulejo.state()");
const command = (script) => browser.evaluate(`azulejo.command(${JSON.stringify(script)})`);
async function until(condition, what) {
    for (let k = 0; k < 1200; k++) {
        const now = await state();
        if (now && condition(now)) return now;
        await new Promise((done) => setTimeout(done, 50));
    }
    throw new Error(`waited in vain for ${what}: ${JSON.stringify(await state())}`);
}
async function shot(name) {
    if (shots) writeFileSync(join(shots, `${name}.png`), await browser.screenshot());
}
const put = (name, bytes) => browser.evaluate(
    `azulejo.put(${JSON.stringify(name)}, Uint8Array.from(atob("${Buffer.from(bytes).toString("base64")}"), (c) => c.charCodeAt(0)))`);
const base64 = (expression) => browser.evaluate(`(() => {
    const bytes = ${expression};
    let text = "";
    for (let k = 0; k < bytes.length; k += 32768) text += String.fromCharCode(...bytes.subarray(k, k + 32768));
    return btoa(text);
})()`);
const bytes = async (expression) => Buffer.from(await base64(expression), "base64");

const tests = {
    async "opens an example, which is drawn soon"() {
        await browser.resize(1280, 800);
        timings["first frame, ms"] = Math.round(await open("?open=cornell"));
        const now = await until((s) => s.objects > 0, "the example");
        assert.equal(now.failure, null);
        await new Promise((done) => setTimeout(done, 1000));
        await shot("cornell");
    },
    async "solves in a worker, while the page stays alive, and stops when asked"() {
        await command("action Solve\nwait 0");
        await until((s) => s.jobs.includes("Solve"), "the solver").catch(() => {});
        // Frames go on while the solver works.
        const frames = await browser.evaluate(`new Promise((done) => {
            let count = 0;
            const next = () => (count++, requestAnimationFrame(next));
            next();
            setTimeout(() => done(count), 1000);
        })`);
        assert.ok(frames > 3, `${frames} frames in a second`);
        await command("engine rays");
    },
    async "has the bits of a desktop"() {
        for (const file of existsSync(expected) ? readdirSync(expected).sort() : []) {
            const [scene, name] = file.split("@");
            const text = readFileSync(join(workspace, "examples", `${scene}.grf`)).toString("base64");
            const start = Date.now();
            const found = await bytes(`azulejo.bits("${name}", Uint8Array.from(atob("${text}"), (c) => c.charCodeAt(0)))`);
            timings[`${scene} ${name}, ms`] = Date.now() - start;
            const wanted = readFileSync(join(expected, file));
            compare(`${scene} ${name}`, found, wanted);
        }
    },
};

const differences = [];
function compare(what, found, wanted) {
    if (found.equals(wanted)) return;
    let count = Math.abs(found.length - wanted.length);
    for (let k = 0; k < Math.min(found.length, wanted.length); k++) count += Number(found[k] !== wanted[k]);
    differences.push(`${what}: ${count} of ${wanted.length} bytes differ`);
}

let failed = 0;
for (const [name, test] of Object.entries(tests)) {
    try {
        await test();
        console.log(`ok: ${name}`);
    } catch (error) {
        failed++;
        console.log(`FAILED: ${name}: ${error.stack}`);
        await shot(`failed-${failed}`).catch(() => {});
    }
}
for (const [what, value] of Object.entries(timings)) console.log(`${what}: ${value}`);
for (const difference of differences) console.log(`DIFFERS: ${difference}`);
const problems = browser.problems();
for (const problem of problems) console.log(`problem: ${problem}`);
await browser.close();
server.close();
process.exit(failed || differences.length ? 1 : 0);
