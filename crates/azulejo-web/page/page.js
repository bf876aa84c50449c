// The page around the program: starts it, and says what has happened when it has stopped.
import init, * as azulejo from "./azulejo_web.js";

const card = document.getElementById("card");
const text = document.getElementById("text");
const choices = document.getElementById("choices");
const canvas = document.getElementById("workbench");

/** The last recovery copy of the scene, which survives the program. */
let kept = null;
let hasFailed = false;

function save(bytes, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([bytes]));
  link.download = name;
  link.click();
}

function choice(label, action) {
  const button = document.createElement("button");
  button.textContent = label;
  button.onclick = action;
  choices.append(button);
}

/** Covers the window, which no longer answers. */
function fail(message) {
  if (hasFailed) return;
  hasFailed = true;
  card.hidden = false;
  text.textContent = message;
  choices.replaceChildren();
  const scene = () => {
    try {
      return azulejo.scene() ?? kept;
    } catch {
      return kept;
    }
  };
  const bytes = scene();
  if (bytes) choice("Save the scene", () => save(bytes, "azulejo.grf"));
  choice("Start again", () => location.reload());
}

/** What the program exports. */
let program;

// Called by the program.
/** The number of JavaScript's objects that the program knows, and which of them a worker has under the same name. */
globalThis.azulejoReferences = () => {
  const table = program.__wbindgen_externrefs;
  const named = [];
  for (let k = 0; k < table.length; k++) {
    if (table.get(k) === performance) named.push([k, "performance"]);
    if (table.get(k) === globalThis) named.push([k, "globalThis"]);
  }
  return { count: table.length, named };
};
globalThis.azulejoKeep = (bytes) => {
  kept = bytes.slice();
};
globalThis.azulejoFailed = (message) => setTimeout(() => fail(message));

addEventListener("error", (event) => {
  // What a trap without a message mostly is.
  if (event.error instanceof WebAssembly.RuntimeError)
    setTimeout(() => fail("The program has stopped; probably there was not enough memory for this model."));
});
canvas.addEventListener("webglcontextlost", () => fail("The browser has taken the graphics card away."));
addEventListener("beforeunload", (event) => {
  try {
    if (globalThis.azulejo.asks && !hasFailed && azulejo.is_changed()) event.preventDefault();
  } catch {
    // The program is at work.
  }
});
// Files that miss the window must not replace the page.
for (const kind of ["dragover", "drop"]) addEventListener(kind, (event) => event.preventDefault());

/** For tests, and for whoever wants to control the page from its console. */
globalThis.azulejo = {
  /** Whether the user is asked before changes are lost. */
  asks: true,
  /** Plays lines of the workbench's scripts; resolves when they are done. */
  async command(script) {
    azulejo.play(script);
    for (;;) {
      await new Promise((done) => setTimeout(done, 50));
      if (hasFailed) throw new Error(text.textContent);
      const outcome = azulejo.outcome();
      if (outcome === "") return;
      if (outcome !== undefined) throw new Error(outcome);
    }
  },
  state: () => JSON.parse(azulejo.state() ?? "null"),
  put: (name, bytes, opens = true) => azulejo.put_file(name, bytes, opens),
  get: (path) => azulejo.get_file(path),
  scene: () => azulejo.scene(),
  bits: (name, text) => azulejo.bits_of(name, text),
};

try {
  program = await init({ module_or_path: new URL("azulejo_web_bg.wasm", import.meta.url) });
  await azulejo.start(canvas, location.search);
  card.hidden = true;
  globalThis.azulejo.started = performance.now();
} catch (error) {
  const why = error?.message ?? String(error);
  if (!hasFailed) fail(`azulejo does not run in this browser: ${why}. It needs WebGPU or WebGL 2.`);
}
