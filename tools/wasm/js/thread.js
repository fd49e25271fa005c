// What runs in a PlanishWorker's thread.
import { load } from './index.js';

let port; // to whoever has started this
const fits = new Map();
let planish;

function listening(id, name) {
  return (...value) => port.postMessage({ id, event: name, value });
}

const DO = {
  async load({ wasm }) {
    planish = await load({ wasm });
  },
  fit({ id, mesh, options }) {
    const listeners = { progress: listening(id, 'progress'), warning: listening(id, 'warning') };
    const source = mesh.bytes ? planish.read(mesh.bytes, mesh.name) : planish.mesh(mesh);
    try {
      const fit = planish.fit(source, { ...options, ...listeners });
      fits.set(id, fit);
      return { fit: id, info: fit.info, warnings: fit.warnings };
    } finally {
      source.dispose();
    }
  },
  fitFile({ id, bytes, name, options }) {
    return planish.fitFile(bytes, name, { ...options, progress: listening(id, 'progress'), warning: listening(id, 'warning') });
  },
  fitFiles({ id, files, options }) {
    return planish.fitFiles(files, { ...options, progress: listening(id, 'progress'), warning: listening(id, 'warning') });
  },
  call({ fit, name, given }) {
    const result = fits.get(fit)[name](...given);
    if (name !== 'cage') return result;
    const arrays = result.arrays();
    result.dispose();
    return arrays;
  },
};

async function answer(message) {
  const { id } = message;
  try {
    const value = await DO[message.do](message);
    const moved = Object.values(value ?? {}).map((part) => part?.buffer).filter((buffer) => buffer);
    port.postMessage({ id, value }, value?.buffer ? [value.buffer] : [...new Set(moved)]);
  } catch (error) {
    const { message: text, code = 'INTERNAL_ERROR', element = -1 } = error;
    port.postMessage({ id, error: { message: text, code, element } });
  }
}

// No await outside of functions, which bundlers refuse for older browsers.
if (globalThis.postMessage) {
  port = globalThis;
  port.onmessage = (event) => answer(event.data);
} else {
  import(/* @vite-ignore */ 'node:worker_threads').then(({ parentPort }) => {
    port = parentPort;
    port.on('message', answer);
  });
}
