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
  const doubles = /within|error|diagonal|degrees|^[uv]$/;
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
      const type = doubles.test(second) ? 'f64' : /^(positions|interpolation)$/.test(second) ? 'ptr' : 'i32';
      lines.push(`${second} ${type} ${size}\n`);
      size += 8;
    }
  }
  end(struct);
  return text;
}

// Memory, files and calls of a library: planish_fit_file() copies the file, and keeps what it was told. Of options it
// refuses speed.
const STUB = `
const LAYOUT = '@LAYOUT@';
export default async function make() {
  const files = new Map(), taken = new Set(), calls = [], functions = new Map();
  const module = globalThis.planishStub = { HEAPU8: new Uint8Array(1 << 20), files, taken, calls, functions, handles: new Map(), made: 0, status: 0, error: '' };
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
      mkdir: () => {},
      readdir: (folder) => ['.', '..', ...[...files.keys()].filter((path) => path.startsWith(folder + '/'))
        .map((path) => path.slice(folder.length + 1))],
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
    _planish_options_create: (at) => {
      const handle = 1000 + module.made++;
      module.handles.set(handle, { set: [] });
      new DataView(module.HEAPU8.buffer).setUint32(at, handle, true);
      return 0;
    },
    _planish_options_set: (at, name, value) => {
      module.handles.get(at).set.push([text(name), text(value)]);
      if (text(name) !== 'speed') return 0;
      module.error = 'options.speed: there is no such option here';
      return 2;
    },
    _planish_options_on_progress: (at, call) => { module.handles.get(at).progress = call; },
    _planish_options_on_warning: (at, call) => { module.handles.get(at).warning = call; },
    _planish_options_free: (at) => { if (!module.handles.delete(at)) throw new Error('no options'); },
    _planish_fit_info_init: (at, size) => module.HEAPU8.fill(0, at, at + size),
    _planish_fit_file: (from, to, options, info) => {
      calls.push({ from: text(from), to: text(to), set: module.handles.get(options).set });
      module.told?.(module.handles.get(options), info);
      if (module.status === 0) files.set(text(to), files.get(text(from)).slice());
      return module.status;
    },
    _planish_fit_files: (inputs, count, folder, extension, options, failed) => {
      const view = new DataView(module.HEAPU8.buffer);
      const from = Array.from({ length: count }, (_, i) => text(view.getUint32(inputs + 4 * i, true)));
      calls.push({ from, folder: text(folder), extension: text(extension), set: module.handles.get(options).set });
      from.forEach((path, i) => {
        const stem = path.replace('/in/', '').replace(/\\.[^.]*$/, '');
        if (files.get(path).length === 0) return functions.get(failed)(0, i, constant(path + ': is empty'));
        files.set(text(folder) + '/' + stem + '.' + text(extension), files.get(path).slice());
        if (module.handles.get(options).set.some(([name]) => name === 'page')) files.set('/pages/' + stem + '.html', 'page of ' + stem);
      });
      files.set('/pages/index.html', 'sheet');
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

// Where a member of a struct lies.
function offset(struct, member) {
  let found;
  for (const line of layout().trim().split('\n')) {
    const [first, second, third] = line.split(' ');
    if (first === 'struct') found = second === struct;
    else if (found && first === member) return Number(third);
  }
  assert.fail(`${struct} has no ${member}`);
}

function nothingIsLeft() {
  assert.equal(module.taken.size, 0, 'memory');
  assert.equal(module.functions.size, 0, 'functions');
  assert.equal(module.handles.size, 0, 'options');
  assert.deepEqual([...module.files.keys()], []);
}

function refused(call, code, words) {
  assert.throws(call, (error) => error instanceof library.PlanishError && error.code === code && words.test(error.message));
  nothingIsLeft();
}

test('options reach the library by name, as text', () => {
  module.told = ({ progress }, info) => {
    assert.equal(progress, undefined);
    const word = module._malloc(8); // of the library, which outlives the call
    module.taken.delete(word);
    module.stringToUTF8('fair', word);
    new DataView(module.HEAPU8.buffer).setUint32(info + offset('planish_fit_info', 'interpolation'), word, true);
  };
  const result = planish.fitFile(new Uint8Array([1, 2, 3]), 'duck.GLB', {
    levels: [2, 0], lods: 'msft', interpolation: 'fair', tolerance: 1e-7, maxIterations: 12, within: 'auto', stepFaceSize: 4,
    polish: undefined,
  });
  assert.equal(result.info.interpolation, 'fair');
  assert.deepEqual([...result.bytes], [1, 2, 3]);
  assert.deepEqual(module.calls.at(-1), {
    from: '/in/duck.GLB', to: '/out/surface.glb',
    set: [['levels', '2,0'], ['lods', 'msft'], ['interpolation', 'fair'], ['tolerance', '1e-7'], ['max_iterations', '12'],
      ['within', 'auto'], ['step_face_size', '4']],
  });
  nothingIsLeft();
});

test('warnings are heard, exceptions come out, and nothing is left behind', () => {
  module.told = ({ warning }) => {
    const call = module.functions.get(warning);
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

test('many files go one after another, and one that fails stops nobody', () => {
  module.told = undefined;
  const files = [{ bytes: new Uint8Array([1]), name: 'in/a.obj' }, { bytes: new Uint8Array(0), name: 'b.b.stl' }, { bytes: new Uint8Array([2]), name: 'c.glb' }];
  const made = planish.fitFiles(files, { extension: 'ply', page: true, levels: [1] });
  assert.deepEqual(made, {
    files: [
      { name: 'in/a.obj', bytes: new Uint8Array([1]), page: 'page of a' }, { name: 'b.b.stl', error: 'b.b.stl: is empty' },
      { name: 'c.glb', bytes: new Uint8Array([2]), page: 'page of c' },
    ],
    warnings: [], sheet: 'sheet',
  });
  assert.deepEqual(module.calls.at(-1), {
    from: ['/in/a.obj', '/in/b.b.stl', '/in/c.glb'], folder: '/out', extension: 'ply', set: [['levels', '1'], ['page', '/pages']],
  });
  nothingIsLeft();
  assert.equal(planish.fitFiles(files.slice(2)).sheet, undefined);
  refused(() => planish.fitFiles(files, { extension: 'gltf' }), 'INVALID_ARGUMENT', /beside it/);
  [module.status, module.error] = [2, '/in/a.obj, /in/c.glb: one name'];
  refused(() => planish.fitFiles(files), 'INVALID_ARGUMENT', /^in\/a.obj, c.glb: one name/);
  [module.status, module.error] = [0, ''];
});

test('errors name the file and what was wrong', () => {
  module.told = undefined;
  [module.status, module.error] = [3, '/in/duck.glb: meshes[0] is no mesh'];
  refused(() => planish.fitFile(new Uint8Array(4), 'duck.glb'), 'UNREADABLE_INPUT', /^duck.glb: meshes/);
  [module.status, module.error] = [0, ''];
  for (const output of ['x.gltf', 'x.JSON'])
    refused(() => planish.fitFile(new Uint8Array(4), 'duck.glb', { output }), 'INVALID_ARGUMENT', /beside/);
  refused(() => planish.fitFile(new Uint8Array(4), 'duck.glb', { speed: 1 }), 'INVALID_ARGUMENT', /^options.speed: there is no such/);
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
