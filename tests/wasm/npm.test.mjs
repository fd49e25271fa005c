// The npm package as its users have it: packed, installed into an empty folder, imported by name.
// PLANISH_NPM: the folder that tools/wasm makes.
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { cpSync, existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath, pathToFileURL } from 'node:url';

const root = fileURLToPath(new URL('../../', import.meta.url));
const modules = join(root, 'tests/wasm/modules/node_modules');
const folder = mkdtempSync(join(tmpdir(), 'planish-npm-'));
const installed = (name) => import(pathToFileURL(join(folder, 'node_modules/planish', name)));
const scene = (name) => new Uint8Array(readFileSync(join(root, 'scenes', name)));
const cube = {
  positions: [-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1],
  faces: [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
};
const diagonal = 2 * Math.sqrt(3);
let library, planish;

before(async () => {
  const packed = execFileSync('npm', ['pack', '--silent', '--pack-destination', folder, process.env.PLANISH_NPM],
    { encoding: 'utf8' }).trim();
  writeFileSync(join(folder, 'package.json'), '{"type": "module", "private": true}');
  execFileSync('npm', ['install', '--silent', '--offline', '--no-audit', '--no-fund', join(folder, packed)], { cwd: folder });
  if (existsSync(join(modules, 'three'))) cpSync(join(modules, 'three'), join(folder, 'node_modules/three'), { recursive: true });
  library = await installed('index.js');
  planish = await library.load();
});
after(() => rmSync(folder, { recursive: true, force: true }));

function refused(call, code, words) {
  assert.throws(call, (error) => error instanceof library.PlanishError && error.code === code && words.test(error.message) ||
    assert.fail(`${error.code}: ${error.message}`));
}

test('the surface passes through the vertices', () => {
  for (const interpolation of ['progressive', 'fair']) {
    const fit = planish.fit(cube, { interpolation });
    assert.equal(fit.info.interpolation, interpolation);
    const surface = fit.evaluate(2);
    assert.equal(surface.indices.length, 6 * 6 * 16);
    surface.baseVertices.forEach((vertex, i) => {
      for (let d = 0; d < 3; ++d)
        assert.ok(Math.abs(surface.positions[3 * i + d] - cube.positions[3 * vertex + d]) < 2e-6 * diagonal);
    });
    for (let i = 0; i < surface.normals.length; i += 3)
      assert.ok(Math.abs(Math.hypot(...surface.normals.subarray(i, i + 3)) - 1) < 1e-6);
    fit.dispose();
    refused(() => fit.evaluate(1), 'INVALID_ARGUMENT', /disposed/);
  }
});

test('triangles are closed and turned outwards', () => {
  const fit = planish.fit(cube, { creases: 'ignore' });
  for (const surface of [fit.evaluate(2), fit.tessellate({ chordError: 1e-3 })]) {
    const edges = new Map();
    let volume = 0;
    const at = (i) => surface.positions.subarray(3 * i, 3 * i + 3);
    for (let t = 0; t < surface.indices.length; t += 3) {
      const [a, b, c] = surface.indices.subarray(t, t + 3);
      for (const [from, to] of [[a, b], [b, c], [c, a]]) edges.set(`${from} ${to}`, (edges.get(`${from} ${to}`) ?? 0) + 1);
      const [p, q, r] = [at(a), at(b), at(c)];
      volume += (p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2]) + p[2] * (q[0] * r[1] - q[1] * r[0])) / 6;
    }
    for (const [edge, count] of edges) {
      assert.equal(count, 1);
      assert.ok(edges.has(edge.split(' ').reverse().join(' ')));
    }
    assert.ok(volume > 8, 'more than the cube inside');
  }
});

test('far from the origin nothing is lost', () => {
  const far = { ...cube, positions: cube.positions.map((x) => x + 1e8) };
  const near = planish.fit(cube).evaluate(1), moved = planish.fit(far).evaluate(1, { origin: 'center' });
  near.positions.forEach((x, i) => assert.ok(Math.abs(x - (moved.positions[i] + moved.origin[i % 3] - 1e8)) < 1e-5));
});

test('closest points and rays', () => {
  const fit = planish.fit(cube);
  const closest = fit.closest([...cube.positions, 0, 0, 9]);
  for (let i = 0; i < 8; ++i) assert.ok(closest.distances[i] < 2e-6 * diagonal);
  assert.ok(Math.abs(closest.positions[26] + closest.distances[8] - 9) < 1e-9);
  const rays = fit.rays([0, 0, 9, 0, 50, 9], [0, 0, -2, 0, 0, -1]);
  assert.ok(Math.abs(2 * rays.t[0] - closest.distances[8]) < 1e-9);
  assert.equal(rays.faces[1], -1);
});

// Without a list of all that differs.
const equal = (a, b, bound = 0) => a.length === b.length && a.every((value, i) => Math.abs(value - b[i]) <= bound);

test('vertices move, and the surface follows where they reach', () => {
  const mesh = planish.read(scene('goblet.obj'), 'goblet.obj');
  const given = mesh.arrays();
  for (const interpolation of ['progressive', 'fair']) {
    const fit = planish.fit(mesh, { interpolation });
    const editor = fit.edit(1);
    const first = editor.rows();
    const shown = { positions: first.positions.slice(), normals: first.normals.slice() };
    const to = [0, 1, 2].map((d) => given.positions[3 * 4000 + d] + [0.004, -0.002, 0.003][d]);
    const follow = (change) => change.rows.forEach((range) => {
      for (const name of ['positions', 'normals']) shown[name].set(range[name], 3 * range.first);
    });
    const change = editor.move([4000], to);
    follow(change);
    assert.deepEqual([...change.vertices], [4000]);
    assert.equal(change.isWhole, false);
    const reached = change.rows.reduce((sum, { count }) => sum + count, 0);
    assert.ok(reached > 9 && reached < shown.positions.length / 6, `${reached} rows`);
    // As if the mesh had been so from the start.
    const moved = { ...given, positions: given.positions.slice() };
    moved.positions.set(to, 3 * 4000);
    const anew = planish.fit(moved, { interpolation }).evaluate(1);
    const row = anew.baseVertices.indexOf(4000);
    for (let d = 0; d < 3; ++d) assert.ok(Math.abs(shown.positions[3 * row + d] - to[d]) < 1e-6 * fit.info.diagonal);
    const gap = anew.positions.reduce((most, x, i) => Math.max(most, Math.abs(x - shown.positions[i])), 0);
    assert.ok(gap < 1e-5 * fit.info.diagonal, `${interpolation}: ${gap}`);
    assert.ok(equal(editor.fit().evaluate(1).positions, shown.positions, 1e-9));
    assert.ok(editor.closest(to).distances[0] < 1e-6 * fit.info.diagonal);
    assert.ok(editor.state.canUndo && editor.state.errorBound < 1e-6);
    follow(editor.undo());
    assert.deepEqual(editor.points, given.positions);
    assert.ok(equal(shown.positions, first.positions, 1e-6 * fit.info.diagonal) && equal(shown.normals, first.normals, 1e-4));
    follow(editor.redo());
    assert.deepEqual([...editor.points.subarray(3 * 4000, 3 * 4000 + 3)], to);
    const selected = editor.select([4000], 0.02 * fit.info.diagonal);
    assert.equal(selected.weights[selected.vertices.indexOf(4000)], 1);
    follow(editor.transform(selected, [1, 0, 0, 0.01, 0, 1, 0, 0, 0, 0, 1, 0]));
    assert.ok(Math.abs(editor.points[3 * 4000] - to[0] - 0.01) < 1e-12);
    assert.ok(equal(editor.fit().evaluate(1).normals, shown.normals, 1e-6));
    editor.dispose();
    fit.dispose();
  }
  mesh.dispose();
});

test('an editor makes edges sharp, and refuses what it cannot do', () => {
  const editor = planish.fit(cube, { creases: 'ignore' }).edit(2, { origin: 'center' });
  const near = editor.rays([-0.9, -0.9, 9], [0, 0, -1]).positions[2];
  const change = editor.setSharp({ edges: [[4, 5], [5, 6], [6, 7], [7, 4]] });
  assert.equal(change.isWhole, true);
  const sharp = editor.rays([-0.9, -0.9, 9], [0, 0, -1]).positions[2];
  assert.ok(Math.abs(sharp - near) > 1e-3, 'asked of the surface as it is now');
  refused(() => editor.setSharp({ edges: [[0, 6]] }), 'INVALID_ARGUMENT', /edge/);
  refused(() => editor.move([99], [0, 0, 0]), 'INVALID_ARGUMENT', /99/);
  refused(() => editor.move([0, 1], [0, 0, 0]), 'INVALID_ARGUMENT', /x, y, z of 2/);
  refused(() => editor.move([0], [NaN, 0, 0]), 'INVALID_ARGUMENT', /0/);
  refused(() => planish.fit(cube).edit(7), 'INVALID_ARGUMENT', /0 to 6/);
  editor.dispose();
  refused(() => editor.undo(), 'INVALID_ARGUMENT', /disposed/);
});

test('a cage is fitted to its own surface', () => {
  const cage = planish.fit(cube, { interpolation: 'progressive' }).cage();
  const arrays = cage.arrays();
  assert.equal(arrays.faceSizes.length, 6);
  assert.ok(arrays.positions[0] < -1.2, 'outside of the cube');
});

test('what rides along', () => {
  const fit = planish.fit({
    ...cube, uvs: [0, 0, 1, 0, 1, 1, 0, 1], faceUvs: cube.faces.flatMap(() => [0, 1, 2, 3]),
    colors: cube.positions.flatMap((x, i) => (i % 3 ? [] : [1, 0, 0.5, 1])),
    groups: [{ name: 'low', material: 'clay' }, { name: 'rest' }], faceGroups: [0, 1, 1, 1, 1, 1],
  });
  const surface = fit.evaluate(2);
  assert.deepEqual(surface.groups[0], { name: 'low', material: 'clay' });
  assert.equal(surface.faceGroups.filter((group) => group === 0).length, 16);
  assert.equal(surface.faceUvs.length, surface.faceVertices.length);
  assert.ok(surface.uvs.every((x) => x >= -1e-9 && x <= 1 + 1e-9));
  assert.ok(surface.colors.every((x, i) => Math.abs(x - [1, 0, 0.5, 1][i % 4]) < 1e-6));
});

test('files', () => {
  const mesh = planish.read(scene('goblet.obj'), 'goblet.obj');
  const fit = planish.fit(mesh);
  assert.equal(fit.info.vertexCount, 8194);
  const glb = fit.glb(1);
  assert.equal(new TextDecoder().decode(glb.subarray(0, 4)), 'glTF');
  assert.ok(planish.read(glb, 'again.glb').arrays().positions.length >= 3 * 8194);
  assert.match(new TextDecoder().decode(fit.write('x.obj', 0)), /^v /m);
});

test('files are called as the caller calls them', () => {
  const { bytes } = planish.fitFile(scene('goblet.obj'), 'scenes/goblet.obj', { output: 'out/cup.step', levels: 0 });
  assert.match(new TextDecoder().decode(bytes.subarray(0, 400)), /FILE_NAME\('goblet'/);
  refused(() => planish.fitFile(scene('goblet.obj'), 'goblet.obj', { output: 'tiles.json' }), 'INVALID_ARGUMENT', /beside it/);
  // Input and output may have the same name.
  assert.ok(planish.fitFile(scene('goblet.obj'), 'goblet.obj', { output: 'goblet.obj', levels: 0 }).bytes.length > 1e5);
});

test('a glTF keeps all that is no triangle, with levels of detail', () => {
  const given = planish.fit(cube).glb(0);
  const { bytes, info } = planish.fitFile(given, 'cube.glb', { levels: [2, 1, 0], lods: 'msft' });
  const document = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + new DataView(bytes.buffer).getUint32(12, true))));
  assert.equal(info.converged, true);
  assert.deepEqual(document.extensionsUsed, ['MSFT_lod']);
  assert.equal(document.meshes.length, 3);
  refused(() => planish.fitFile(given, 'cube.glb', { levels: [2, 1] }), 'INVALID_ARGUMENT', /options.lods msft/);
  refused(() => planish.fitFile(given.subarray(0, 99), 'cube.glb'), 'UNREADABLE_INPUT', /^cube.glb/);
});

test('a file comes with its report and its page', () => {
  const made = planish.fitFile(planish.fit(cube).glb(0), 'chair.glb', { compress: 'meshopt', report: true, page: true });
  assert.equal(made.report.outputs[0].sha256, createHash('sha256').update(made.bytes).digest('hex'));
  assert.match(made.page, /class="payload"/);
  assert.equal(planish.fitFile(scene('goblet.obj'), 'goblet.obj', { levels: 0 }).page, undefined);
});

test('a contact sheet shows many files', () => {
  const files = ['goblet.obj', 'cube.obj'].map((name) => ({ bytes: scene(name), name }));
  files.push({ bytes: new Uint8Array([7]), name: 'broken.stl' });
  const made = planish.fitFiles(files, { levels: 0, page: true });
  assert.deepEqual(made.files.map(({ error }) => !error), [true, true, false]);
  assert.match(made.files[2].error, /^broken.stl/);
  for (const { bytes, page } of made.files.slice(0, 2)) {
    assert.equal(String.fromCharCode(...bytes.subarray(0, 4)), 'glTF');
    assert.match(page, /class="payload"/);
  }
  for (const name of ['goblet.html', 'cube.html', 'broken']) assert.ok(made.sheet.includes(name), name);
  refused(() => planish.fitFiles([files[0], files[0]]), 'INVALID_ARGUMENT', /goblet/);
});

test('errors say what, where and which', () => {
  const bytes = (text) => new TextEncoder().encode(text);
  refused(() => planish.fit({ positions: [0, 0, 0, 1, 0, 0], faces: [[0, 1, 7]] }), 'UNUSABLE_MESH', /face 0 names vertex 7 of 2/);
  refused(() => planish.fit(cube, { maxIteration: 1 }), 'INVALID_ARGUMENT', /did you mean max_iterations\?/);
  refused(() => planish.fit(cube, { outliers: 'off' }), 'INVALID_ARGUMENT', /outliers: is of files and points/);
  refused(() => planish.fit(cube, { tolerance: -1 }), 'INVALID_ARGUMENT', /tolerance.*1e-6/);
  refused(() => planish.fit(cube, { interpolation: 'best' }), 'INVALID_ARGUMENT', /interpolation: "best" is not one of auto/);
  refused(() => planish.fit(cube, { speed: 1 }), 'INVALID_ARGUMENT', /options.speed: there is no such option here/);
  refused(() => planish.fit({ ...cube, faces: [[0, 1, 2.5]] }), 'INVALID_ARGUMENT', /2.5/);
  refused(() => planish.fit({ positions: [1, 2] }), 'INVALID_ARGUMENT', /multiple of 3/);
  refused(() => planish.fit(cube).evaluate(9), 'INVALID_ARGUMENT', /0 to 6/);
  refused(() => planish.read(bytes('v 1 2\n'), 'bad.obj'), 'UNREADABLE_INPUT', /^bad.obj:1: vertex has 2/);
  refused(() => planish.fit(cube).write('x.iges'), 'INVALID_ARGUMENT', /x.iges/);
});

test('headers that promise more than there can be take no memory', () => {
  const bytes = (text) => new TextEncoder().encode(text);
  const count = 2 ** 33;
  const ply = (vertices, faces) => bytes(`ply\nformat binary_little_endian 1.0\nelement vertex ${vertices}\nproperty double x\n` +
    `property double y\nproperty double z\nelement face ${faces}\nproperty list uchar int vertex_indices\nend_header\n`);
  for (const file of [ply(count, 1), ply(3, count), ply(count + 3, 1)])
    refused(() => planish.read(file, 'large.ply'), 'UNREADABLE_INPUT', /large.ply/);
  refused(() => planish.read(bytes(`OFF\n${count} 1 0\n0 0 0\n`), 'large.off'), 'UNREADABLE_INPUT', /large.off/);
  const stl = new Uint8Array(84);
  new DataView(stl.buffer).setUint32(80, 0xffffffff, true);
  refused(() => planish.read(stl, 'large.stl'), 'UNREADABLE_INPUT', /large.stl/);
});

test('progress rises to 1 and cancels', () => {
  const parts = [];
  planish.fit(cube, { progress: (step, part) => void parts.push(part) });
  assert.ok(parts.every((part, i) => i === 0 || part >= parts[i - 1]));
  assert.equal(parts.at(-1), 1);
  refused(() => planish.fit(cube, { progress: () => false }), 'CANCELLED', /cancelled/);
  assert.throws(() => planish.fit(cube, { progress: () => { throw new Error('of the caller'); } }), /of the caller/);
});

test('memory comes back', () => {
  const mesh = planish.read(scene('goblet.obj'), 'goblet.obj');
  const glb = () => {
    const fit = planish.fit(mesh);
    const bytes = fit.glb(2);
    fit.dispose();
    return bytes;
  };
  const first = glb();
  for (let i = 0; i < 5; ++i) assert.deepEqual(glb(), first);
});

test('a worker works and stops', async () => {
  const { PlanishWorker } = await installed('worker.js');
  const worker = await PlanishWorker.create();
  const bytes = scene('goblet.obj');
  let calls = 0;
  const fit = await worker.fit({ bytes, name: 'goblet.obj' }, { progress: () => void ++calls });
  assert.ok(calls > 0);
  assert.deepEqual((await fit.evaluate(1)).positions, planish.fit(planish.read(bytes, 'goblet.obj')).evaluate(1).positions);
  await assert.rejects(fit.evaluate(11), (error) => error.code === 'INVALID_ARGUMENT');
  const stopped = worker.fit({ bytes, name: 'goblet.obj' });
  setTimeout(() => worker.stop(), 20);
  await assert.rejects(stopped, (error) => error.code === 'CANCELLED');
  await assert.rejects(worker.fit(cube), (error) => error.code === 'CANCELLED');
});

test('three.js geometries', { skip: !existsSync(join(modules, 'three')) && 'three is not installed' }, async () => {
  const { BoxGeometry } = await import(pathToFileURL(join(folder, 'node_modules/three/build/three.module.js')));
  const { fromGeometry, toGeometry } = await installed('three.js');
  const box = new BoxGeometry(2, 2, 2);
  const mesh = fromGeometry(box);
  assert.equal(mesh.positions.length, 3 * 8, 'the 24 that it has are one again');
  const fit = planish.fit(mesh);
  const surface = fit.evaluate(2);
  const geometry = toGeometry(surface);
  assert.deepEqual(geometry.groups.map((group) => group.materialIndex), [0, 1, 2, 3, 4, 5]);
  assert.equal(geometry.groups.reduce((sum, group) => sum + group.count, 0), geometry.getIndex().count);
  // Each side's own texture: 0 to 1, and positions as the surface has them.
  const uv = geometry.getAttribute('uv');
  for (let i = 0; i < uv.count; ++i) assert.ok(uv.getX(i) > -1e-6 && uv.getX(i) < 1 + 1e-6);
  geometry.computeBoundingSphere();
  assert.ok(geometry.boundingSphere.radius < 2);
});

test("the README's first example runs as it stands", () => {
  const text = readFileSync(join(folder, 'node_modules/planish/README.md'), 'utf8').match(/```js\n([^]*?)```/)[1];
  writeFileSync(join(folder, 'example.js'), `${text}\nconsole.log(positions.length, file.length, nearest[2]);\n`);
  const [positions, file, top] = execFileSync('node', ['example.js'], { cwd: folder, encoding: 'utf8' }).split(' ');
  // A cube's edges stay sharp: a grid for each side.
  assert.equal(Number(positions), 3 * 6 * 25);
  assert.ok(Number(file) > 1000);
  assert.equal(Number(top), 1);
});

test('npx planish is the command', () => {
  const run = (...given) => execFileSync('npx', ['--no-install', 'planish', ...given], { cwd: folder, encoding: 'utf8', stdio: 'pipe' });
  writeFileSync(join(folder, 'g.obj'), scene('goblet.obj'));
  run('fit', 'g.obj', '-o', 'out.glb', '--page', 'p.html', '--report', 'r.json');
  for (const file of ['out.glb', 'p.html']) assert.ok(existsSync(join(folder, file)));
  assert.equal(JSON.parse(readFileSync(join(folder, 'r.json'))).jobs?.length ?? 1, 1);
  assert.throws(() => run('fit', 'g.obj', '-o', 'out.glb'), (error) => error.status === 7 && /--force/.test(error.stderr));
  writeFileSync(join(folder, 'points.xyz'), '0 0 0\n1 0 0\n0 1 0\n0 0 1\n');
  assert.throws(() => run('fit', 'points.xyz', '-o', 'points.glb'), (error) => /planish-reconstruct/.test(error.stderr));
  // Standard output is a terminal where it is one.
  assert.match(run('--help'), /fit/);
  const terminal = (command) => execFileSync('script', ['-qec', `npx --no-install planish ${command}`, '/dev/null'], { cwd: folder, encoding: 'utf8', stdio: 'pipe' });
  assert.match(terminal('--help'), /fit/);
  assert.throws(() => terminal('fit g.obj -o -'), (error) => error.status === 2 && /not written to a terminal/.test(error.stdout));
  const written = execFileSync('npx', ['--no-install', 'planish', 'fit', 'g.obj', '-o', '-', '--quiet'], { cwd: folder, maxBuffer: 1e8 });
  assert.deepEqual(written, readFileSync(join(folder, 'out.glb')));
  // 2.7 GB are not begun.
  writeFileSync(join(folder, 'arm.obj'), scene('rocker_arm.obj'));
  assert.throws(() => run('fit', 'arm.obj', '-o', '-', '--levels', '6'), (error) => error.status === 6 && /bytes are more than this program can hold/.test(error.stderr));
});

test('npx planish takes the native program where its package is', () => {
  const native = join(folder, 'node_modules', `planish-${process.platform}-${process.arch}`);
  const run = (...given) => spawnSync('npx', ['--no-install', 'planish', ...given], { cwd: folder, encoding: 'utf8', input: 'a mesh' });
  const { version } = JSON.parse(readFileSync(join(folder, 'node_modules/planish/package.json')));
  const install = (facts) => writeFileSync(join(native, 'package.json'), JSON.stringify({ version, program: 'bin/planish', ...facts }));
  const isNative = () => /^native/.test(run('--version').stdout);
  mkdirSync(join(native, 'bin'), { recursive: true });
  writeFileSync(join(native, 'bin/planish'), `#!/bin/sh
case $1 in
  --version) echo "native" ;;
  end) kill -TERM $$ ;;
  *) echo "$# $2 $(cat)"; exit 5 ;;
esac
`, { mode: 0o755 });
  install({});
  assert.ok(isNative());
  const done = run('fit', 'two words', '-o');
  assert.equal(done.stdout, '3 two words a mesh\n');
  assert.equal(done.status, 5);
  // npx tells a signal by its number.
  const ended = run('end');
  assert.ok(ended.signal === 'SIGTERM' || ended.status === 128 + 15, JSON.stringify(ended));
  // Another version, or a glibc that this system has not.
  install({ version: '0.0.1' });
  assert.ok(!isNative());
  install({ glibc: '2.17' });
  assert.ok(isNative());
  install({ glibc: '2.999' });
  assert.ok(!isNative());
  rmSync(native, { recursive: true });
  assert.ok(!isNative());
});

test('a file that is larger than all memory is refused before it is read', async () => {
  const module = await (await installed('planish_library.mjs')).default();
  module.FS.writeFile('/large.ply', 'ply\n');
  module.FS.lookupPath('/large.ply').node.usedBytes = 2 ** 32 + 100;
  const path = module._malloc(16), handle = module._malloc(4);
  module.stringToUTF8('/large.ply', path, 16);
  assert.equal(module._planish_mesh_read(path, handle), 6);
  assert.match(module.UTF8ToString(module._planish_last_error()), /large.ply: 4294967396 bytes are to be read, and \d+ bytes of memory are free/);
  // An array of more than all memory is no internal error.
  const { Memory } = await installed('memory.js');
  new Memory(module).use((memory) => {
    const corners = memory.i32([0, 1, 2]);
    const arrays = { positions: corners, vertex_count: 2e8, face_vertices: corners, corner_count: 3, face_count: 1, corners_per_face: 3 };
    assert.equal(module._planish_mesh_create(memory.struct('mesh_arrays', arrays), handle), 6);
    assert.match(module.UTF8ToString(module._planish_last_error()), /^out of memory/);
  });
  // Nor are arrays cut to 32 bits.
  refused(() => planish.fit({ positions: { length: 3 * 2 ** 28 }, indices: [] }), 'NO_MEMORY', /6442450944 bytes/);
});

test('what is compiled in has its notices', () => {
  const notices = readFileSync(join(folder, 'node_modules/planish/NOTICES.txt'), 'utf8');
  for (const name of ['planish', 'libosd-dev', 'libglm-dev', 'nlohmann', 'tinygltf', 'meshoptimizer', 'zlib', 'cli11', 'stb', 'emscripten', 'musl'])
    assert.match(notices, new RegExp(name, 'i'));
});
