// What the library's calls say. Its memory, written to and read by the layout that it tells itself, and what stands in
// it.

/** `code` is one of the C header's statuses; `element` the face, vertex or byte spoken of, or -1. */
export class PlanishError extends Error {
  constructor(message, code, element = -1) {
    super(message);
    this.name = 'PlanishError';
    this.code = code;
    this.element = element;
  }
}

export function refuse(message) {
  throw new PlanishError(message, 'INVALID_ARGUMENT');
}

/** The values, if they are whole and small enough for int32: typed arrays would cut what is not. */
export function whole(values, name) {
  for (const value of values)
    if (!Number.isInteger(value) || value < -0x80000000 || value > 0x7fffffff)
      refuse(`${name}: ${value} is no 32-bit integer`);
  return values;
}

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

const layouts = new WeakMap();

function layoutOf(module) {
  if (!layouts.has(module)) {
    const layout = {};
    let struct;
    for (const line of module.UTF8ToString(module._planish_wasm_layout()).trim().split('\n')) {
      const [first, second, third] = line.split(' ');
      if (first === 'struct') {
        struct = layout[second.slice('planish_'.length)] = { size: Number(third), members: {} };
      } else {
        struct.members[first] = { type: second, offset: Number(third) };
      }
    }
    layouts.set(module, layout);
  }
  return layouts.get(module);
}

const SETTERS = { f64: 'setFloat64', i32: 'setInt32', u32: 'setUint32', ptr: 'setUint32' };
const GETTERS = { f64: 'getFloat64', i64: 'getBigInt64', i32: 'getInt32', u32: 'getUint32', ptr: 'getUint32' };

/** What it has taken is freed at the end of use(). */
export class Memory {
  #ends = [];
  constructor(module) {
    this.module = module;
    this.layout = layoutOf(module);
  }

  use(work) {
    try {
      return work(this);
    } finally {
      for (const work of this.#ends.reverse()) work();
    }
  }

  /** Work for the end of use(), the last first. */
  atEnd(work) {
    this.#ends.push(work);
  }

  // Anew each time: the heap may have grown since.
  get #buffer() {
    return this.module.HEAPU8.buffer;
  }

  take(bytes) {
    // Of more than 32 bits malloc() would see the rest.
    const pointer = bytes <= 0xffffffff ? this.module._malloc(Math.max(bytes, 8)) >>> 0 : 0;
    if (!pointer) {
      throw new PlanishError(`${bytes} bytes are more than WebAssembly has left`, 'NO_MEMORY');
    }
    this.atEnd(() => this.module._free(pointer));
    return pointer;
  }

  #put(Type, values) {
    const pointer = this.take(values.length * Type.BYTES_PER_ELEMENT);
    new Type(this.#buffer, pointer, values.length).set(values);
    return pointer;
  }

  f64(values) {
    return this.#put(Float64Array, values);
  }

  f32(values) {
    return this.#put(Float32Array, values);
  }

  i32(values) {
    return this.#put(Int32Array, values);
  }

  text(value) {
    const size = this.module.lengthBytesUTF8(value) + 1;
    const pointer = this.take(size);
    this.module.stringToUTF8(value, pointer, size);
    return pointer;
  }

  texts(values) {
    return this.#put(Uint32Array, values.map((value) => this.text(value)));
  }

  readTexts(pointer, count) {
    return Array.from(this.copy(Uint32Array, pointer, count), (text) => this.module.UTF8ToString(text));
  }

  callback(signature, call) {
    const pointer = this.module.addFunction(call, signature);
    this.atEnd(() => this.module.removeFunction(pointer));
    return pointer;
  }

  /** Room for a pointer that a function sets. */
  out() {
    const pointer = this.take(4);
    new DataView(this.#buffer).setUint32(pointer, 0, true);
    return pointer;
  }

  pointer(at) {
    return new DataView(this.#buffer).getUint32(at, true);
  }

  /** A struct with the library's defaults, but for the values. */
  struct(name, values) {
    const { size, members } = this.layout[name];
    const pointer = this.take(size);
    this.module[`_planish_${name}_init`](pointer, size);
    const view = new DataView(this.#buffer);
    for (const [member, value] of Object.entries(values))
      view[SETTERS[members[member].type]](pointer + members[member].offset, value, true);
    return pointer;
  }

  read(name, pointer) {
    const view = new DataView(this.#buffer);
    const result = {};
    for (const [member, { type, offset }] of Object.entries(this.layout[name].members))
      result[member] = Number(view[GETTERS[type]](pointer + offset, true));
    return result;
  }

  copy(Type, pointer, length) {
    return pointer ? new Type(this.#buffer, pointer, length).slice() : new Type(0);
  }
}
