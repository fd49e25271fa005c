// Unpacks each X_meshopt.glb or .gltf with meshoptimizer's own decoder and compares it with
// X_plain.glb: the same triangles within 1e-4, normals within 0.03 degrees, the same colours.
'use strict';
const fs = require('fs');
const path = require('path');
const {MeshoptDecoder} = require('meshoptimizer');

function load(file) {
  const bytes = fs.readFileSync(file);
  if (file.endsWith('.gltf')) {
    const json = JSON.parse(bytes);
    const uri = decodeURIComponent(json.buffers[0].uri);
    return {json, binary: fs.readFileSync(path.join(path.dirname(file), uri))};
  }
  const length = bytes.readUInt32LE(12);
  return {json: JSON.parse(bytes.toString('utf8', 20, 20 + length)),
          binary: bytes.subarray(20 + length + 8)};
}

function bytesOf({json, binary}, index) {
  const view = json.bufferViews[index];
  const packed = (view.extensions || {}).EXT_meshopt_compression;
  const from = packed || view;
  const offset = from.byteOffset || 0;
  const source = new Uint8Array(binary.subarray(offset, offset + from.byteLength));
  if (!packed) return source;
  const target = new Uint8Array(packed.count * packed.byteStride);
  if (target.length !== view.byteLength) throw new Error('byteLength differs from the stream');
  MeshoptDecoder.decodeGltfBuffer(target, packed.count, packed.byteStride, source, packed.mode,
                                  packed.filter);
  return target;
}

function values(file, index) {
  const accessor = file.json.accessors[index];
  const size = {SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4}[accessor.type];
  const [Numbers, most] = {5122: [Int16Array, 32767], 5123: [Uint16Array, 65535],
                           5125: [Uint32Array, 1], 5126: [Float32Array, 1]}[accessor.componentType];
  const numbers = new Numbers(bytesOf(file, accessor.bufferView).buffer);
  const stride = (file.json.bufferViews[accessor.bufferView].byteStride ||
                  size * Numbers.BYTES_PER_ELEMENT) / Numbers.BYTES_PER_ELEMENT;
  const scale = accessor.normalized ? 1 / most : 1;
  return Array.from({length: accessor.count}, (_, i) =>
      Array.from(numbers.subarray(i * stride, i * stride + size), (x) => x * scale));
}

// Triangles by their middle, which no two of the samples share.
function corners(file) {
  const found = [];
  const {translation = [0, 0, 0], scale = [1, 1, 1]} = file.json.nodes[0];
  const placed = (p) => p.map((x, k) => x * scale[k] + translation[k]);
  for (const primitive of file.json.meshes[0].primitives) {
    const attributes = Object.fromEntries(Object.entries(primitive.attributes).map(
        ([name, index]) => [name, name === 'POSITION' ? values(file, index).map(placed)
                                                      : values(file, index)]));
    const indices = values(file, primitive.indices).map(([i]) => i);
    const triangles = [];
    for (let i = 0; i < indices.length; i += 3) {
      const three = indices.slice(i, i + 3).map((v) => Object.fromEntries(
          Object.entries(attributes).map(([name, all]) => [name, all[v]])));
      triangles.push(three);
    }
    found.push({names: Object.keys(attributes), triangles});
  }
  return found;
}

const key = (triangle) => [0, 1, 2].map((k) => Math.round(
    (triangle[0].POSITION[k] + triangle[1].POSITION[k] + triangle[2].POSITION[k]) / 3 * 500));

function compare(packed, plain) {
  const near = (a, b, error) => a.every((x, k) => Math.abs(x - b[k]) <= error);
  const turn = (a, b) => Math.hypot(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                                    a[0] * b[1] - a[1] * b[0]) / Math.hypot(...a);
  if (packed.length !== plain.length) throw new Error('primitives differ');
  packed.forEach((part, p) => {
    if (part.triangles.length !== plain[p].triangles.length) throw new Error('counts differ');
    if (String(part.names) !== String(plain[p].names)) throw new Error('attributes differ');
    const byPlace = new Map();
    for (const triangle of plain[p].triangles) {
      const at = String(key(triangle));
      byPlace.set(at, [...(byPlace.get(at) || []), triangle]);
    }
    const same = (a, b) => near(a.POSITION, b.POSITION, 1e-4) &&
        turn(a.NORMAL, b.NORMAL) < 0.03 / 57.2958 &&
        part.names.every((name) => name === 'POSITION' || name === 'NORMAL' ||
                         near(a[name], b[name], 1e-5));
    for (const triangle of part.triangles) {
      const [x, y, z] = key(triangle);
      let candidates = [];
      for (const d of [-1, 0, 1]) for (const e of [-1, 0, 1]) for (const f of [-1, 0, 1])
        candidates = candidates.concat(byPlace.get(String([x + d, y + e, z + f])) || []);
      const found = candidates.some((other) => [0, 1, 2].some((r) =>
          [0, 1, 2].every((k) => same(triangle[k], other[(k + r) % 3]))));
      if (!found) throw new Error('a triangle is nowhere in the plain file: ' +
                                  JSON.stringify(triangle));
    }
  });
}

MeshoptDecoder.ready.then(() => {
  for (const file of process.argv.slice(2)) {
    compare(corners(load(file)), corners(load(file.replace(/_meshopt\.gl(b|tf)$/, '_plain.glb'))));
    console.log(`${path.basename(file)}: as the plain file`);
  }
  if (process.argv.length < 3) throw new Error('no file to compare');
}).catch((error) => {
  console.error(error);
  process.exit(1);
});
