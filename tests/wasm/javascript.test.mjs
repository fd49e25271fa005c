// What of the npm package needs no WebAssembly: that its modules fit together, what they write into the library's
// memory, and that nothing is left behind: on a library that only remembers.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { cpSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath, pathToFileURL } from 'node:url';

const root = fileURLToPath(new URL('../../', import.meta.url));
const folder = mkdtempSync(join(tmpdir(), 'planish-javascript-'));
let library, planish, module;

// Members as layout.cpp names them, four or eight bytes each.
function layout() {
  const source = readFileSync(join(root, 'tools/wasm/layout.cpp'), 'utf8');
  const doubles = /tolerance|weld|within|step_angle|error|diagonal|degrees|^[uv]$/;
  let text = '', size = 0, lines = [];
  const end = (name) => {
    if (name) text += `struct planish_${name} ${size}\n${lines.join('')}`;
    [size, lines] = [0, []];
  };
  let struct;
  for (const [, kind, first, second] of source.matchAll(/^    (STRUCT|MEMBER)\((\w+)(?:, (\w+))?\)/gm)) {
    if (kind === 'STRUCT') {
      end(struct);
      struct = first;
    } else {
      const type = doubles.test(second) ? 'f64' : /^(positions|coarser_levels|creases|progress|warning)$/.test(second) ? 'ptr' : 'i32';
      lines.push(`${second} ${type} ${size}\n`);
      size += 8;
    }
  }
  end(struct);
  return text;
}

// Memory, files and calls of a library: planish_fit_file() copies the file, and keeps what it was told.
const STUB = `
const LAYOUT = '@LAYOUT@';
export default async function make() {
  const files = new Map(), taken = new Set(), calls = [], functions = new Map();
  const module = globalThis.planishStub = { HEAPU8: new Uint8Array(1 << 20), files, taken, calls, functions, status: 0, error: '' };
  let top = 64;
  const text = (at) => {
    const end = module.HEAPU8.indexOf(0, at);
    return new TextDecoder().decode(module.HEAPU8.slice(at, end));
  };
  const put = (value, at) => module.HEAPU8.set([...new TextEncoder().encode(value), 0], at);
  const constant = (value) => {
    const at = top;
    top += Math.ceil((value.length + 9) / 8) * 8;
    put(value, at);
    return at;
  };
  const places = new Map();
  return Object.assign(module, {
    FS: {
      writeFile: (path, bytes) => files.set(path, bytes),
      readFile: (path) => files.get(path),
      unlink: (path) => { if (!files.delete(path)) throw new Error('no ' + path); },
      analyzePath: (path) => ({ exists: files.has(path) }),
    },
    UTF8ToString: text,
    lengthBytesUTF8: (value) => new TextEncoder().encode(value).length,
    stringToUTF8: put,
    addFunction: (call) => { functions.set(functions.size + 1, call); return functions.size; },
    removeFunction: (at) => { if (!functions.delete(at)) throw new Error('no function'); },
    _malloc: (bytes) => { const at = top; top += Math.ceil((bytes + 7) / 8) * 8; taken.add(at); return at; },
    _free: (at) => { if (!taken.delete(at)) throw new Error('freed twice'); },
    _planish_wasm_layout: () => places.get('layout') ?? (places.set('layout', constant(LAYOUT)), places.get('layout')),
    _planish_version: () => constant('9.9'),
    _planish_last_error: () => constant(module.error),
    _planish_last_error_element: () => 7,
    _planish_fit_options_init: (at, size) => module.HEAPU8.fill(0, at, at + size),
    _planish_fit_info_init: (at, size) => module.HEAPU8.fill(0, at, at + size),
    _planish_fit_file: (from, to, level, options, info) => {
      calls.push({ from: text(from), to: text(to), level, options });
      module.told?.(options, info);
      if (module.status === 0) files.set(text(to), files.get(text(from)).slice());
      return module.status;
    },
  });
}
`;

before(async () => {
  cpSync(join(root, 'tools/wasm/js'), folder, { recursive: true });
  writeFileSync(join(folder, 'package.json'), '{"type": "module"}');
  writeFileSync(join(folder, 'planish_library.mjs'), STUB.replace('@LAYOUT@', layout().replaceAll('\n', '\\n')));
  library = await import(pathToFileURL(join(folder, 'index.js')));
  planish = await library.load();
  module = globalThis.planishStub;
});
after(() => rmSync(folder, { recursive: true, force: true }));

function members() {
  const found = {};
  let struct;
  for (const line of layout().trim().split('\n')) {
    const [first, second, third] = line.split(' ');
    if (first === 'struct') struct = found[second] = {};
    else struct[first] = { type: second, offset: Number(third) };
  }
  return found.planish_fit_options;
}

function nothingIsLeft() {
  assert.equal(module.taken.size, 0, 'memory');
  assert.equal(module.functions.size, 0, 'functions');
  assert.deepEqual([...module.files.keys()], []);
}

function refused(call, code, words) {
  assert.throws(call, (error) => error instanceof library.PlanishError && error.code === code && words.test(error.message));
  nothingIsLeft();
}

test('coarser levels, level and options reach the library', () => {
  const at = members();
  let told;
  module.told = (options) => {
    const view = new DataView(module.HEAPU8.buffer);
    const levels = view.getUint32(options + at.coarser_levels.offset, true);
    told = {
      count: view.getInt32(options + at.coarser_level_count.offset, true),
      levels: [...new Int32Array(module.HEAPU8.buffer, levels, 2)],
      method: view.getInt32(options + at.method.offset, true),
      tolerance: view.getFloat64(options + at.tolerance.offset, true),
    };
  };
  const result = planish.fitFile(new Uint8Array([1, 2, 3]), 'duck.GLB',
    { level: 3, coarserLevels: [2, 0], method: 'fair', tolerance: 1e-5 });
  assert.deepEqual(told, { count: 2, levels: [2, 0], method: 2, tolerance: 1e-5 });
  assert.deepEqual([...result.bytes], [1, 2, 3]);
  assert.equal(module.calls.at(-1).from, '/from.glb');
  assert.equal(module.calls.at(-1).to, '/to.glb');
  assert.equal(module.calls.at(-1).level, 3);
  nothingIsLeft();
});

test('warnings are heard, exceptions come out, and nothing is left behind', () => {
  const at = members();
  module.told = (options) => {
    const view = new DataView(module.HEAPU8.buffer);
    const call = module.functions.get(view.getUint32(options + at.warning.offset, true));
    const code = module._malloc(8);
    module.stringToUTF8('odd', code);
    call(0, code, code);
    module._free(code);
  };
  const heard = [];
  const { warnings } = planish.fitFile(new Uint8Array(4), 'a.glb', { warning: (code, message) => heard.push([code, message]) });
  assert.deepEqual(warnings, [{ code: 'odd', message: 'odd' }]);
  assert.deepEqual(heard, [['odd', 'odd']]);
  assert.throws(() => planish.fitFile(new Uint8Array(4), 'a.glb', { warning() { throw new Error('mine'); } }), /^Error: mine$/);
  nothingIsLeft();
});

test('errors name the file and what was wrong', () => {
  module.told = undefined;
  [module.status, module.error] = [3, '/from.glb: meshes[0] is no mesh'];
  refused(() => planish.fitFile(new Uint8Array(4), 'duck.glb'), 'UNREADABLE_INPUT', /^duck.glb: meshes/);
  [module.status, module.error] = [0, ''];
  refused(() => planish.fitFile(new Uint8Array(4), 'duck.glb', { output: 'x.gltf' }), 'INVALID_ARGUMENT', /beside/);
  refused(() => planish.fitFile(new Uint8Array(4), 'duck.glb', { coarserLevels: [0.5] }), 'INVALID_ARGUMENT', /0.5/);
  refused(() => planish.fitFile(new Uint8Array(4), 'duck.glb', { speed: 1 }), 'INVALID_ARGUMENT', /"speed" is no option/);
  refused(() => planish.fit({ positions: [1, 2] }), 'INVALID_ARGUMENT', /multiple of 3/);
});

test('the package has every module, and no module is long', () => {
  const listed = readFileSync(join(root, 'tools/wasm/CMakeLists.txt'), 'utf8').match(/set\(npm_parts ([^)]*)\)/)[1];
  const imported = new Set();
  const follow = (name) => {
    if (imported.has(name)) return;
    imported.add(name);
    const text = readFileSync(join(root, 'tools/wasm/js', name), 'utf8');
    assert.ok(text.split('\n').length < 400, name);
    for (const [, other] of text.matchAll(/from '\.\/(\w+\.js)'/g)) follow(other);
  };
  for (const name of ['index.js', 'worker.js', 'thread.js', 'three.js']) follow(name);
  for (const name of imported) assert.ok(listed.includes(`js/${name}`), `${name} is not in npm_parts`);
});

test('the page unpacks what xz has packed', () => {
  const unlzma = new Function(`${readFileSync(join(root, 'tools/wasm/page/lzma.js'), 'utf8')}; return unlzma;`)();
  let seed = 1;
  const noise = Uint8Array.from({ length: 70000 }, () => (seed = (seed * 48271) % 0x7fffffff) & 255);
  const far = new Uint8Array(3 << 20); // distances of more than a few bits
  for (const at of [0, 2500000]) far.set(noise, at);
  const settings = [['-9e'], ['-0'], ['--lzma1=lc=0,lp=2,pb=0']];
  for (const bytes of [new Uint8Array(0), noise.subarray(0, 1), noise, new Uint8Array(90000), far, readFileSync(join(root, 'scenes/goblet.obj'))])
    for (const setting of settings) {
      const packed = execFileSync('xz', ['--format=lzma', ...setting, '--stdout'], { input: bytes, maxBuffer: 1 << 30 });
      packed.writeBigUInt64LE(BigInt(bytes.length), 5);
      assert.equal(Buffer.compare(unlzma(packed), bytes), 0, `${bytes.length} bytes, ${setting}`);
    }
});
