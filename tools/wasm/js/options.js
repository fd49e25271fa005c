// What a fit is told: options of planish_options_set(), by the names of scene files in camel case, as text.
import { check } from './handle.js';

/** PLANISH_LEVEL_AUTO: what the option `levels` says; else 2, of a dense mesh 1. */
export const LEVEL_AUTO = -1;

const nameOf = (key) => key.replace(/[A-Z]/g, (letter) => `_${letter.toLowerCase()}`);

/** Options of a call into the library, for as long as its memory is in use; progress() and warning() are heard. An
 * exception of theirs must not pass through the library: it cancels, and end() throws it. */
export class FitOptions {
  #thrown;
  constructor(memory, { progress, warning, ...options }, warnings) {
    const { module } = memory;
    const handle = memory.out();
    check(module, module._planish_options_create(handle));
    const pointer = memory.pointer(handle);
    memory.atEnd(() => module._planish_options_free(pointer));
    this.pointer = pointer;
    // Lists become texts with commas between.
    for (const [key, value] of Object.entries(options))
      if (value !== undefined)
        check(module, module._planish_options_set(pointer, memory.text(nameOf(key)), memory.text(String(value))));
    const guarded = (call) => {
      try {
        return call();
      } catch (error) {
        this.#thrown ??= error;
        return false;
      }
    };
    if (progress) {
      module._planish_options_on_progress(pointer, memory.callback('iiid', (user, step, fraction) =>
        guarded(() => progress(module.UTF8ToString(step), fraction)) === false ? 1 : 0), 0);
    }
    module._planish_options_on_warning(pointer, memory.callback('viii', (user, code, message) => {
      const told = { code: module.UTF8ToString(code), message: module.UTF8ToString(message) };
      warnings.push(told);
      if (warning) guarded(() => warning(told.code, told.message));
    }), 0);
  }

  /** Throws what progress() or warning() has thrown. */
  end() {
    if (this.#thrown) throw this.#thrown;
  }
}
