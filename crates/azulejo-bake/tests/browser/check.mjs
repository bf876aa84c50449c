// What a page does in headless Chromium: node check.mjs PAGE.html EXPECTED.json
//
// EXPECTED is { camera, width, height, operates, points: [{ x, y, radiance, light, error }] }: what the linear
// picture holds at places, in pixels from the upper left; x and y end in .5. A radiance of null is a place where
// nothing is; light and error are compared where they are given. With `operates`, the controls are tried as well.
// Prints what was compared; the exit status is 0 if all is well, 1 if not, and 77 if there is no Chromium.

import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser, findChromium } from "./chromium.mjs";

const TOLERANCE = 0.01;

const [page, expectedPath] = process.argv.slice(2);
const chromium = findChromium();
if (!chromium) {
    console.log("no Chromium: install it (Debian: apt install chromium), or name it in AZULEJO_CHROMIUM");
    process.exit(77);
}
const expected = JSON.parse(readFileSync(expectedPath, "utf8"));
const failures = [];
const check = (isTrue, what) => {
    if (!isTrue) {
        failures.push(what);
    }
};

const wait = (ms) => new Promise((done) => setTimeout(done, ms));

// The numbers of a picture at the points.
async function pixels(browser, quantity) {
    const { camera, width, height, points } = expected;
    const places = points.map(({ x, y }) => 4 * (Math.floor(y) * width + Math.floor(x)));
    return browser.evaluate(`(() => {
        const numbers = azulejo.render(${JSON.stringify({ camera, width, height, quantity })});
        return ${JSON.stringify(places)}.map((k) => Array.from(numbers.subarray(k, k + 4)));
    })()`);
}

async function compare(browser) {
    const [radiance, light] = [await pixels(browser, "radiance"), await pixels(browser, "light")];
    let worst = 0;
    expected.points.forEach((point, k) => {
        const place = `at ${point.x}, ${point.y}`;
        check((point.radiance !== null) === radiance[k][3] > 0.999, `${place}: coverage ${radiance[k][3]}`);
        const relative = (found, right) => Math.abs(found - right) / Math.max(Math.abs(right), 1e-6);
        const most = (found, right) => Math.max(0, ...(right ?? []).map((value, c) => relative(found[c], value)));
        const difference = Math.max(most(radiance[k], point.radiance), most(light[k], point.light));
        worst = Math.max(worst, difference);
        check(difference <= TOLERANCE, `${place}: ${radiance[k]} and ${light[k]}, ` +
            `expected ${point.radiance} and ${point.light}`);
        // Errors are kept in coarse steps.
        check(!point.error || relative(light[k][3], point.error) < 0.06,
            `${place}: error ${light[k][3]}, expected ${point.error}`);
    });
    console.log(`${expected.points.length} points, largest difference ${(100 * worst).toFixed(3)}%`);
}

// Nothing is drawn while nothing changes, and each control does what it says.
async function operate(browser) {
    const state = (expression) => browser.evaluate(expression);
    await wait(500);
    const still = await state("azulejo.frames");
    await wait(300);
    check((await state("azulejo.frames")) === still, "draws although nothing changes");
    const { width, height } = { width: 800, height: 600 };
    await browser.resize(width, height);
    await wait(300);
    check((await state("azulejo.frames")) > still, "does not draw when its size changes");
    const size = await state(`[document.getElementById("picture").width, document.getElementById("picture").height]`);
    check(size[0] === width && size[1] === height, `the picture has ${size} pixels`);

    const before = await state("azulejo.pick(0.5, 0.4)");
    check(before && before.light > 0 && before.error > 0, `no value under the pointer: ${JSON.stringify(before)}`);
    await drag(browser, [400, 300], [480, 320]);
    const after = await state("azulejo.pick(0.5, 0.4)");
    check(Math.abs(after.distance - before.distance) > 1e-3 * before.distance, "dragging turns nothing");
    await browser.send("Input.dispatchMouseEvent", { type: "mouseMoved", x: 390, y: 250 });
    await wait(300);
    const readout = await state(`document.getElementById("readout").textContent`);
    check(/W\/m²/.test(readout) && /%/.test(readout), `the pointer shows "${readout}"`);

    const distance = (await state("azulejo.pick(0.5, 0.4)")).distance;
    // A step takes a frame, which a busy machine without a graphics card has few of.
    const walked = async () => (await state("azulejo.pick(0.5, 0.4)")).distance < 0.98 * distance;
    for (let tries = 0; tries < 10 && !(await walked()); tries += 1) {
        await key(browser, "KeyW", "w", 400);
    }
    check(await walked(), "W does not walk");
    const shown = `document.querySelector('input[name="show"]:checked').value`;
    const choices = [["KeyF", "f", "light"], ["KeyX", "x", "error"], ["KeyX", "x", "lit"], ["KeyL", "l", "plain"]];
    for (const [code, text, value] of choices) {
        await key(browser, code, text, 30);
        check((await state(shown)) === value, `${code} shows ${await state(shown)}`);
    }
    await state(`document.getElementById("picture").focus()`);
    await key(browser, "Enter", "Enter", 30);
    check(await state(`!document.getElementById("mark").hidden`), "Enter marks no value");
    await pinch(browser);
    await key(browser, "KeyO", "o", 30);
    const eye = await state("azulejo.place()");
    await drag(browser, [400, 300], [300, 300]);
    check(JSON.stringify(eye) === JSON.stringify(await state("azulejo.place()")), "looking around moves the eye");
    await key(browser, "KeyH", "h", 30);
    check(await state(`document.getElementById("help").open`), "H shows no help");
    await state(`document.getElementById("help").close()`);
    await loseContext(browser);
}

async function drag(browser, from, to) {
    const mouse = (type, [x, y]) => browser.send("Input.dispatchMouseEvent",
        { type, x, y, button: "left", buttons: type === "mouseReleased" ? 0 : 1, clickCount: 1 });
    await mouse("mousePressed", from);
    await mouse("mouseMoved", to);
    await mouse("mouseReleased", to);
    await wait(300);
}

// Two fingers that go apart bring the eye nearer.
async function pinch(browser) {
    const distance = async () => (await browser.evaluate("azulejo.pick(0.5, 0.4)")).distance;
    const before = await distance();
    const touch = (type, ...places) => browser.send("Input.dispatchTouchEvent",
        { type, touchPoints: places.map(([x, y], id) => ({ x, y, id })) });
    await touch("touchStart", [380, 250], [420, 250]);
    for (let k = 1; k <= 5; k++) {
        await touch("touchMove", [380 - 8 * k, 250], [420 + 8 * k, 250]);
    }
    await touch("touchEnd");
    await wait(200);
    check((await distance()) < 0.9 * before, "two fingers do not zoom");
}

async function key(browser, code, text, milliseconds) {
    const typed = text.length === 1 ? { text } : {};
    await browser.send("Input.dispatchKeyEvent", { type: "keyDown", code, key: text, ...typed });
    await wait(milliseconds);
    await browser.send("Input.dispatchKeyEvent", { type: "keyUp", code, key: text });
    await wait(100);
}

// The graphics card goes and comes back, and everything is as before.
async function loseContext(browser) {
    await browser.evaluate(`azulejo.set({ show: "lit" })`);
    const before = await pixels(browser, "radiance");
    await browser.evaluate(`(() => {
        const gl = document.getElementById("picture").getContext("webgl2");
        window.lost = gl.getExtension("WEBGL_lose_context");
        lost.loseContext();
    })()`);
    await wait(300);
    const says = await browser.evaluate(`document.getElementById("message").hidden`);
    check(says === false, "nothing is said while the graphics card is away");
    await browser.evaluate("lost.restoreContext()");
    await wait(600);
    check(await browser.evaluate(`document.getElementById("message").hidden`), "the message stays");
    const after = await pixels(browser, "radiance");
    check(JSON.stringify(after) === JSON.stringify(before), "another picture after the card was lost");
}

// A browser without WebGL 2 is told so.
async function refuse(address) {
    const without = new Browser(chromium, ["--disable-3d-apis"]);
    await without.open(address);
    await without.evaluate("azulejo.ready.catch(() => {})");
    const message = await without.evaluate(`document.getElementById("message").textContent`);
    check(/WebGL 2/.test(message), `without WebGL 2 the page says "${message}"`);
    await without.close();
}

const address = pathToFileURL(resolve(page)).href;
const browser = new Browser(chromium);
try {
    const start = Date.now();
    await browser.open(address);
    await browser.evaluate("azulejo.ready.then(() => 1)");
    console.log(`first picture after ${Date.now() - start} ms`);
    await compare(browser);
    if (expected.operates) {
        await operate(browser);
        await refuse(address);
    }
    browser.problems().forEach((problem) => check(false, `the page reports: ${problem}`));
    const foreign = browser.requests().filter((url) => url !== address && !/^(data|blob):/.test(url));
    check(foreign.length === 0, `the page asks for ${foreign}`);
} catch (problem) {
    failures.push(String(problem.stack));
} finally {
    await browser.close();
}
failures.forEach((failure) => console.log(failure));
process.exit(failures.length > 0 ? 1 : 0);
