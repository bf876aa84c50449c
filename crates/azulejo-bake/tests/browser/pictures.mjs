// Pictures of a page for people: node pictures.mjs PAGE.html FOLDER

import { writeFileSync, mkdirSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser, findChromium } from "./chromium.mjs";

const SIZES = { desktop: [1280, 800, 1, false], phone: [390, 844, 2, true] };
const VIEWS = {
    light: `azulejo.set({ show: "lit" })`,
    values: `azulejo.set({ show: "light" })`,
    error: `azulejo.set({ show: "error" })`,
    plain: `azulejo.set({ show: "plain" })`,
    texels: `azulejo.set({ show: "lit", showTexels: true })`,
    outside: `azulejo.set({ show: "lit", showTexels: false, camera: azulejo.head.cameras.length })`,
    help: `document.getElementById("help").showModal()`,
};

const [page, folder, ...wanted] = process.argv.slice(2);
mkdirSync(folder, { recursive: true });
const browser = new Browser(findChromium());
for (const [size, metrics] of Object.entries(SIZES)) {
    await browser.open("about:blank");
    await browser.resize(...metrics);
    const start = Date.now();
    await browser.open(pathToFileURL(resolve(page)).href);
    await browser.evaluate("azulejo.ready.then(() => 1)");
    console.log(`${size}: first picture after ${Date.now() - start} ms`);
    for (const [name, expression] of Object.entries(VIEWS)) {
        if (wanted.length > 0 && !wanted.includes(name)) {
            continue;
        }
        await browser.evaluate(`${expression}, new Promise((done) => setTimeout(done, 700))`);
        if (name === "values" && size === "desktop") {
            await browser.send("Input.dispatchMouseEvent", { type: "mouseMoved", x: 520, y: 560 });
            await new Promise((done) => setTimeout(done, 300));
        }
        writeFileSync(join(folder, `${size}-${name}.png`), await browser.screenshot());
    }
    browser.problems().forEach((problem) => console.log(problem));
}
await browser.close();
