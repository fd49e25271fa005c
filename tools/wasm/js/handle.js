// What stands in the library's memory, and what its calls say.
import { PlanishError, refuse } from './error.js';

const CODES = {
  1: 'INTERNAL_ERROR', 2: 'INVALID_ARGUMENT', 3: 'UNREADABLE_INPUT', 4: 'UNUSABLE_MESH', 6: 'NO_MEMORY',
  7: 'UNWRITABLE_OUTPUT', 130: 'CANCELLED',
};
const NOT_CONVERGED = 5;

/** Whether a status says that there is a result. */
export function isDone(status) {
  return status === 0 || status === NOT_CONVERGED;
}

/** Throws unless the status says that there is a result; `path` is called `name` in messages. */
export function check(module, status, path, name) {
  if (isDone(status)) return status;
  let message = module.UTF8ToString(module._planish_last_error());
  if (path) message = message.replaceAll(path, name);
  throw new PlanishError(message, CODES[status] ?? 'INTERNAL_ERROR', Number(module._planish_last_error_element()));
}

// What is forgotten is freed when it is collected.
const forgotten = new FinalizationRegistry((free) => free());

export class Handle {
  constructor(module, pointer, free) {
    this.module = module;
    this.pointer = pointer;
    this.free = () => module[free](pointer);
    forgotten.register(this, this.free, this);
  }

  get alive() {
    if (!this.pointer) refuse('this was disposed of before');
    return this.pointer;
  }

  dispose() {
    if (!this.pointer) return;
    forgotten.unregister(this);
    this.free();
    this.pointer = 0;
  }
}
