// Reads a mesh of triangles (OBJ), smooths and refines it with manifold-3d, writes an OBJ and prints
// the milliseconds that it took: node manifold_smooth.mjs FOLDER IN.obj N OUT.obj
import fs from 'fs';
import path from 'path';
import {pathToFileURL} from 'url';

const [folder, input, n, output] = process.argv.slice(2);
const entry = path.join(path.resolve(folder), 'node_modules', 'manifold-3d', 'manifold.js');
const {default: load} = await import(pathToFileURL(entry));
const library = await load();
library.setup();

const positions = [], corners = [];
for (const line of fs.readFileSync(input, 'utf8').split('\n')) {
  const words = line.trim().split(/\s+/);
  if (words[0] === 'v') positions.push(...words.slice(1, 4).map(Number));
  if (words[0] === 'f') corners.push(...words.slice(1, 4).map((word) => parseInt(word) - 1));
}
const mesh = new library.Mesh({
  numProp: 3,
  vertProperties: new Float32Array(positions),
  triVerts: new Uint32Array(corners),
});
const start = performance.now();
const refined = new library.Manifold(mesh).smoothOut(180, 0).refine(Number(n));
const made = refined.getMesh();
const took = performance.now() - start;

const lines = [];
for (let v = 0; v < made.numVert; ++v) {
  const at = made.numProp * v;
  lines.push('v ' + [...made.vertProperties.slice(at, at + 3)].join(' '));
}
for (let t = 0; t < made.numTri; ++t)
  lines.push('f ' + [...made.triVerts.slice(3 * t, 3 * t + 3)].map((v) => v + 1).join(' '));
fs.writeFileSync(output, lines.join('\n') + '\n');
console.log(took);
