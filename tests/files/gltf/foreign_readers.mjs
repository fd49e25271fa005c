// Reads X.stl, X.usda and X.obj of a folder by three.js's loaders and compares them with
// X_plain.glb as its document has it: triangles, box, area.
import fs from 'node:fs';
import path from 'node:path';
import {OBJLoader} from 'three/examples/jsm/loaders/OBJLoader.js';
import {STLLoader} from 'three/examples/jsm/loaders/STLLoader.js';
import {USDZLoader} from 'three/examples/jsm/loaders/USDZLoader.js';
import {zipSync} from 'three/examples/jsm/libs/fflate.module.js';

function measure(corners) {
  const box = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  let area = 0;
  for (let i = 0; i < corners.length; i += 3) {
    const [a, b, c] = corners.slice(i, i + 3);
    for (const p of [a, b, c]) {
      for (let k = 0; k < 3; ++k) {
        box[0][k] = Math.min(box[0][k], p[k]);
        box[1][k] = Math.max(box[1][k], p[k]);
      }
    }
    const u = a.map((x, k) => b[k] - x), v = a.map((x, k) => c[k] - x);
    area += Math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                       u[0] * v[1] - u[1] * v[0]) / 2;
  }
  return {triangles: corners.length / 3, box: box.flat(), area};
}

// Corners of a three.js geometry or of all in a scene.
function cornersOf(object) {
  const corners = [];
  const add = (geometry) => {
    const flat = geometry.index ? geometry.toNonIndexed() : geometry;
    const place = flat.attributes.position;
    for (let i = 0; i < place.count; ++i)
      corners.push([place.getX(i), place.getY(i), place.getZ(i)]);
  };
  if (object.isBufferGeometry) add(object);
  else object.traverse((node) => node.geometry && add(node.geometry));
  return corners;
}

function plain(file) {
  const bytes = fs.readFileSync(file);
  const length = bytes.readUInt32LE(12);
  const json = JSON.parse(bytes.toString('utf8', 20, 20 + length));
  const corners = [];
  for (const primitive of json.meshes[0].primitives) {
    const at = (index) => 28 + length +
        (json.bufferViews[json.accessors[index].bufferView].byteOffset || 0);
    const start = at(primitive.attributes.POSITION);
    for (let i = 0; i < json.accessors[primitive.indices].count; ++i) {
      const vertex = bytes.readUInt16LE(at(primitive.indices) + 2 * i);
      corners.push([0, 4, 8].map((k) => bytes.readFloatLE(start + 12 * vertex + k)));
    }
  }
  return measure(corners);
}

const readers = {
  stl: (bytes) => new STLLoader().parse(bytes.buffer.slice(bytes.byteOffset,
                                                           bytes.byteOffset + bytes.length)),
  obj: (bytes) => new OBJLoader().parse(bytes.toString()),
  usda: (bytes) => new USDZLoader().parse(zipSync({'a.usda': new Uint8Array(bytes)}, {level: 0})
                                              .buffer),
};
const folder = process.argv[2];
let count = 0;
for (const file of fs.readdirSync(folder)) {
  const kind = path.extname(file).slice(1);
  if (!(kind in readers)) continue;
  const wanted = plain(path.join(folder, file.replace(/\.\w+$/, '_plain.glb')));
  const found = measure(cornersOf(readers[kind](fs.readFileSync(path.join(folder, file)))));
  const near = (a, b) => Math.abs(a - b) <= 1e-5 * Math.max(1, Math.abs(b));
  // Quads of OBJ and USD may be split on the other diagonal there, so that the area differs a bit.
  const same = found.triangles === wanted.triangles &&
      found.box.every((x, k) => near(x, wanted.box[k])) &&
      Math.abs(found.area - wanted.area) <= (kind === 'stl' ? 1e-5 : 1e-3) * wanted.area;
  console.log(`${file}: ${found.triangles} triangles, area ${found.area}`);
  if (!same) throw new Error(`${file} differs: ${JSON.stringify({found, wanted})}`);
  ++count;
}
if (count < 6) throw new Error(`only ${count} files were read`);
