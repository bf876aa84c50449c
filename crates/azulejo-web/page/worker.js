// A worker: the program with a copy of the page's memory, in which a job waits.
import { initSync, run_job } from "./azulejo_web.js";

const PAGE = 65536;

onmessage = ({ data: { module, memory, references, id } }) => {
  const wasm = initSync({ module });
  const missing = (memory.byteLength - wasm.memory.buffer.byteLength) / PAGE;
  if (missing > 0) wasm.memory.grow(missing);
  new Uint8Array(wasm.memory.buffer).set(new Uint8Array(memory));
  // The memory knows JavaScript's objects by their numbers: clocks have to be where they were.
  const table = wasm.__wbindgen_externrefs;
  if (references.count > table.length) table.grow(references.count - table.length);
  for (const [number, name] of references.named) table.set(number, globalThis[name]);
  run_job(id);
};
