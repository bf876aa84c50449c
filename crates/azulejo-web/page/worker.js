// A worker: the program with a copy of the page's memory, in which a job waits.
import { initSync, run_job } from "./azulejo_web.js";

const PAGE = 65536;

onmessage = ({ data: { module, memory, references, id } }) => {
  const wasm = initSync({ module });
  const missing = (memory.byteLength - wasm.memory.buffer.byteLength) / PAGE;
  if (missing > 0) wasm.memory.grow(missing);
  new Uint8Array(wasm.memory.buffer).set(new Uint8Array(memory));
  // The memory knows how long the table of JavaScript's objects is; here nobody uses the page's.
  const table = wasm.__wbindgen_externrefs;
  if (table && references > table.length) table.grow(references - table.length);
  run_job(id);
};
