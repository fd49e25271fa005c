// What runs in a PlanishWorker's thread.
import { load } from './index.js';

const port = globalThis.postMessage ? globalThis : (await import(/* @vite-ignore */ 'node:worker_threads')).parentPort;
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

if (port.on) port.on('message', answer);
else port.onmessage = (event) => answer(event.data);
