// The same library in a thread of its own: every call is a promise, and stop() ends whatever it is at.
import { PlanishError } from './memory.js';

async function start() {
  // Word for word what bundlers look for, to take the thread's modules along.
  if (globalThis.Worker) return new Worker(new URL('./thread.js', import.meta.url), { type: 'module' });
  const threads = await import(/* @vite-ignore */ 'node:worker_threads');
  return new threads.Worker(new URL('./thread.js', import.meta.url));
}

/** One thread; several make several jobs at once. */
export class PlanishWorker {
  #thread;
  #waiting = new Map();
  #next = 1;

  /** `wasm`: as load() takes it. */
  static async create({ wasm } = {}) {
    const worker = new PlanishWorker();
    worker.#thread = await start();
    const hear = (message) => worker.#hear(message);
    const fail = (error) => worker.#end(error.message ?? 'the worker failed', 'INTERNAL_ERROR');
    if (worker.#thread.on) {
      worker.#thread.on('message', hear);
      worker.#thread.on('error', fail);
    } else {
      worker.#thread.onmessage = (event) => hear(event.data);
      worker.#thread.onerror = fail;
    }
    await worker.#call({ do: 'load', wasm });
    return worker;
  }

  #call(message, listeners = {}) {
    if (!this.#thread) return Promise.reject(new PlanishError('this worker was stopped', 'CANCELLED'));
    const id = this.#next++;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject, listeners });
      this.#thread.postMessage({ ...message, id });
    });
  }

  #hear({ id, event, value, error }) {
    const waiting = this.#waiting.get(id);
    if (!waiting) return;
    if (event) {
      waiting.listeners[event]?.(...value);
      return;
    }
    this.#waiting.delete(id);
    if (error) waiting.reject(new PlanishError(error.message, error.code, error.element));
    else waiting.resolve(value);
  }

  #end(message, code) {
    this.#thread?.terminate();
    this.#thread = undefined;
    for (const { reject } of this.#waiting.values()) reject(new PlanishError(message, code));
    this.#waiting.clear();
  }

  /** Arrays of a mesh, or {bytes, name} of a file. Of the options progress() and warning() are called here. */
  async fit(mesh, { progress, warning, ...options } = {}) {
    const { fit, info, warnings } = await this.#call({ do: 'fit', mesh, options }, { progress, warning });
    const call = (name) => (...given) => this.#call({ do: 'call', fit, name, given });
    const calls = ['evaluate', 'tessellate', 'write', 'glb', 'cage', 'closest', 'rays', 'dispose'];
    return { info, warnings, ...Object.fromEntries(calls.map((name) => [name, call(name)])) };
  }

  /** A file's bytes become another's. Of the options progress() and warning() are called here. */
  fitFile(bytes, name, { progress, warning, ...options } = {}) {
    return this.#call({ do: 'fitFile', bytes, name, options }, { progress, warning });
  }

  /** Many files, and a contact sheet of them. */
  fitFiles(files, { progress, warning, ...options } = {}) {
    return this.#call({ do: 'fitFiles', files, options }, { progress, warning });
  }

  /** Ends the thread; what it was asked for is rejected with the code CANCELLED. */
  stop() {
    this.#end('stopped', 'CANCELLED');
  }
}
