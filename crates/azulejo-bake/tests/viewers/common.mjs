// What the scripts for foreign viewers share: arguments, a server on the loopback interface, and a browser.

import { createServer } from "node:http";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { basename, dirname, extname, join, normalize, resolve, sep } from "node:path";
import { fileURLToPath } from "node:url";
import { Browser, findChromium } from "../browser/chromium.mjs";

// Exit status that says that something is not installed.
export const MISSING = 77;

const TYPES = { ".html": "text/html", ".js": "text/javascript", ".json": "application/json" };

const OPTIONS = ["exr", "picture", "tone", "exposure", "material"];

function missing(message) {
    console.error(message);
    process.exit(MISSING);
}

// The folder with node_modules, if it has the package.
function packages(name) {
    const folder = process.env.AZULEJO_VIEWERS;
    if (!folder || !existsSync(join(folder, "node_modules", name))) {
        missing(`no package ${name}: run "npm install three babylonjs babylonjs-loaders" in a folder outside of the ` +
            "repository and name that folder in AZULEJO_VIEWERS");
    }
    return join(resolve(folder), "node_modules");
}

// MODEL.glb CAMERA.json POINTS.json, and options that are followed by a value.
function parseArguments(list) {
    const [files, options] = [[], {}];
    for (let k = 0; k < list.length; k++) {
        if (list[k].startsWith("--")) {
            options[list[k].slice(2)] = list[++k];
        } else {
            files.push(list[k]);
        }
    }
    const unknown = Object.keys(options).filter((name) => !OPTIONS.includes(name));
    if (files.length < 2 || files.length > 3 || unknown.length > 0 || Object.values(options).includes(undefined)) {
        console.error("usage: MODEL CAMERA.json [POINTS.json] [--exr LIGHT.exr] [--picture OUT.png] " +
            "[--tone aces|linear] [--exposure FACTOR] [--material standard|lambert]");
        process.exit(2);
    }
    return { files, options };
}

// A file below a folder, or null if a path leaves it.
function below(folder, path) {
    const file = normalize(join(folder, decodeURIComponent(path)));
    return file.startsWith(resolve(folder) + sep) ? file : null;
}

// Serves the page, the packages, the module for lightmaps, and the folder of the model.
function serve(here, modules, model, exr) {
    const file = (path) => {
        const [, root, ...rest] = path.split("/");
        const inside = rest.join("/");
        switch (root) {
            case "packages": return below(modules, inside);
            case "model": return below(dirname(resolve(model)), inside);
            case "light.exr": return exr && resolve(exr);
            case "azulejo-lightmap": return below(join(here, "../../../../web/azulejo-lightmap"), inside);
            default: return below(here, root);
        }
    };
    const server = createServer((request, response) => {
        const path = file(new URL(request.url, "http://localhost").pathname);
        if (!path || !existsSync(path)) {
            response.writeHead(404).end();
            return;
        }
        response.writeHead(200, { "content-type": TYPES[extname(path)] || "application/octet-stream" });
        response.end(readFileSync(path));
    });
    return new Promise((done) => server.listen(0, "127.0.0.1", () => done(server)));
}

// Loads a model in `page` (beside this file), which offers `window.show(request)`: a promise of
// { pixels, picture }, linear RGB at the points and a PNG as a data URL. Prints the pixels as JSON.
export async function view(page, packageName) {
    const { files, options } = parseArguments(process.argv.slice(2));
    const [model, cameraPath, pointsPath] = files;
    const modules = packages(packageName);
    const chromium = findChromium();
    if (!chromium) {
        missing("no Chromium: install it, or name it in AZULEJO_CHROMIUM");
    }
    const request = {
        model: `/model/${encodeURIComponent(basename(model))}`,
        camera: JSON.parse(readFileSync(cameraPath, "utf8")),
        points: pointsPath ? JSON.parse(readFileSync(pointsPath, "utf8")) : [],
        exr: options.exr ? "/light.exr" : null,
        tone: options.picture ? options.tone || "aces" : null,
        exposure: options.exposure ? Number(options.exposure) : null,
        material: options.material || "standard",
    };
    const server = await serve(dirname(fileURLToPath(import.meta.url)), modules, model, options.exr);
    const browser = new Browser(chromium);
    try {
        const { width, height } = request.camera;
        await browser.open("about:blank");
        await browser.resize(width, height);
        await browser.open(`http://127.0.0.1:${server.address().port}/${page}`);
        const shown = await browser.evaluate(`window.show(${JSON.stringify(request)})`);
        console.log(JSON.stringify(shown.pixels));
        if (options.picture) {
            writeFileSync(options.picture, Buffer.from(shown.picture.split(",")[1], "base64"));
        }
    } catch (problem) {
        console.error(String(problem.message));
        browser.problems().forEach((text) => console.error(text));
        process.exitCode = 1;
    } finally {
        await browser.close();
        server.close();
    }
}
