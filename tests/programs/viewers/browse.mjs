// A picture of a page once a promise is fulfilled, and when that was, in ms after the page was asked for:
// node browse.mjs URL PROMISE WIDTH HEIGHT OUT.png

import { writeFileSync } from "node:fs";
import { Browser, findChromium } from "../../../crates/azulejo-bake/tests/browser/chromium.mjs";

const [url, promise, width, height, out] = process.argv.slice(2);
const browser = new Browser(findChromium());
await browser.open("about:blank");
await browser.resize(Number(width), Number(height));
await browser.open(url);
const ready = await browser.evaluate(`Promise.resolve(${promise}).then(() => performance.now())`);
console.log(Math.round(ready));
writeFileSync(out, await browser.screenshot());
await browser.close();
