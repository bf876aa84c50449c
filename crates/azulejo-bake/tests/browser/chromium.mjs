// Headless Chromium by its own protocol over a pipe: no package is needed, and no port is opened.

import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { delimiter, join } from "node:path";

const NAMES = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

// The program: $AZULEJO_CHROMIUM, or the first that is in the path; null if there is none.
export function findChromium() {
    const named = process.env.AZULEJO_CHROMIUM;
    if (named) {
        return existsSync(named) ? named : null;
    }
    const folders = (process.env.PATH || "").split(delimiter);
    const all = NAMES.flatMap((name) => folders.map((folder) => join(folder, name)));
    return all.find((path) => existsSync(path)) || null;
}

// A browser with one tab. Its drawing is by software, so that it needs no graphics card.
export class Browser {
    constructor(program, flags = []) {
        this.profile = mkdtempSync(join(tmpdir(), "azulejo-chromium-"));
        this.process = spawn(program, [
            "--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
            "--disable-background-networking", "--disable-component-update", "--disable-sync",
            "--no-first-run", "--hide-scrollbars", "--force-color-profile=srgb",
            `--user-data-dir=${this.profile}`, "--remote-debugging-pipe", ...flags, "about:blank",
        ], { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
        this.next = 1;
        this.waiting = new Map();
        this.events = [];
        this.rest = "";
        this.process.stdio[4].setEncoding("utf8");
        this.process.stdio[4].on("data", (text) => this.received(text));
        this.process.on("exit", () => {
            this.waiting.forEach(({ reject }) => reject(new Error("Chromium has ended")));
            this.waiting.clear();
        });
    }

    received(text) {
        const messages = (this.rest + text).split("\0");
        this.rest = messages.pop();
        for (const message of messages.map((m) => JSON.parse(m))) {
            const waiting = this.waiting.get(message.id);
            if (waiting) {
                this.waiting.delete(message.id);
                message.error ? waiting.reject(new Error(message.error.message)) : waiting.resolve(message.result);
            } else if (message.method) {
                this.events.push(message);
            }
        }
    }

    send(method, params = {}) {
        const id = this.next++;
        const message = { id, method, params, sessionId: this.session };
        this.process.stdio[3].write(JSON.stringify(message) + "\0");
        return new Promise((resolve, reject) => this.waiting.set(id, { resolve, reject }));
    }

    // Opens an address in the tab and waits until it is loaded.
    async open(address) {
        if (!this.session) {
            const { targetInfos } = await this.send("Target.getTargets");
            const tab = targetInfos.find((target) => target.type === "page");
            const attached = await this.send("Target.attachToTarget", { targetId: tab.targetId, flatten: true });
            this.session = attached.sessionId;
            for (const domain of ["Page", "Runtime", "Network", "Log"]) {
                await this.send(`${domain}.enable`);
            }
        }
        this.events = [];
        await this.send("Page.navigate", { url: address });
        await this.until(() => this.events.some((event) => event.method === "Page.loadEventFired"));
    }

    async until(condition, seconds = 60) {
        const end = Date.now() + 1000 * seconds;
        while (!condition()) {
            if (Date.now() > end || this.process.exitCode !== null) {
                throw new Error("waited in vain for Chromium");
            }
            await new Promise((done) => setTimeout(done, 10));
        }
    }

    // The value of an expression in the page; a promise is waited for.
    async evaluate(expression) {
        const { result, exceptionDetails } = await this.send("Runtime.evaluate",
            { expression, awaitPromise: true, returnByValue: true });
        if (exceptionDetails) {
            const { exception, text } = exceptionDetails;
            throw new Error(`in the page: ${(exception && exception.description) || text}`);
        }
        return result.value;
    }

    // Sets the size of the window in CSS pixels, and the pixels in each.
    resize(width, height, deviceScaleFactor = 1, mobile = false) {
        return this.send("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor, mobile });
    }

    // A PNG of the window.
    async screenshot() {
        const { data } = await this.send("Page.captureScreenshot", { format: "png" });
        return Buffer.from(data, "base64");
    }

    // Errors that the page has reported, as texts.
    problems() {
        const text = ({ method, params }) =>
            method === "Runtime.exceptionThrown" ? JSON.stringify(params.exceptionDetails)
                : method === "Log.entryAdded" && params.entry.level === "error" ? params.entry.text
                    : method === "Runtime.consoleAPICalled" && params.type === "error" ? JSON.stringify(params.args)
                        : null;
        return this.events.map(text).filter((t) => t !== null);
    }

    // Addresses that the page has asked the network for.
    requests() {
        const sent = this.events.filter((event) => event.method === "Network.requestWillBeSent");
        return sent.map((event) => event.params.request.url);
    }

    async close() {
        const ended = new Promise((done) => this.process.once("exit", done));
        await Promise.race([this.send("Browser.close").catch(() => {}), ended]);
        await Promise.race([ended, new Promise((done) => setTimeout(done, 3000))]);
        this.process.kill("SIGKILL");
        rmSync(this.profile, { recursive: true, force: true, maxRetries: 5 });
    }
}
