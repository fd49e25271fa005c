// Compares the tangents of GLB files with those that MikkTSpace makes of their triangles.
import fs from 'node:fs';
import {createRequire} from 'node:module';

const {generateTangents} = createRequire(import.meta.url)('mikktspace');
const kWidths = {SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4};

function numbersOf(file) {
  const bytes = fs.readFileSync(file);
  const length = bytes.readUInt32LE(12);
  const json = JSON.parse(bytes.toString('utf8', 20, 20 + length));
  const numbers = (index) => {
    const {bufferView, count, type, componentType} = json.accessors[index];
    const start = 28 + length + (json.bufferViews[bufferView].byteOffset || 0);
    const size = count * kWidths[type];
    return Array.from({length: size}, (_, i) =>
        componentType === 5126 ? bytes.readFloatLE(start + 4 * i) :
        componentType === 5125 ? bytes.readUInt32LE(start + 4 * i) :
                                 bytes.readUInt16LE(start + 2 * i));
  };
  return {json, numbers};
}

let compared = 0, left = 0;
for (const file of process.argv.slice(2)) {
  const {json, numbers} = numbersOf(file);
  for (const {primitives} of json.meshes) {
    for (const {attributes, indices, material} of primitives) {
      if (attributes.TANGENT === undefined) continue;
      const set = json.materials[material].normalTexture.texCoord || 0;
      const corners = numbers(indices);
      const unrolled = (name, width) => {
        const values = numbers(attributes[name]);
        return corners.flatMap((v) => values.slice(width * v, width * v + width));
      };
      const wanted = generateTangents(new Float32Array(unrolled('POSITION', 3)),
                                      new Float32Array(unrolled('NORMAL', 3)),
                                      new Float32Array(unrolled(`TEXCOORD_${set}`, 2)));
      const found = unrolled('TANGENT', 4);
      let worst = 0;
      for (let i = 0; i < found.length; i += 4) {
        // glTF's v runs down, MikkTSpace's up.
        if (found[i + 3] !== -wanted[i + 3])
          throw new Error(`${file}: corner ${i / 4} is the other way round`);
        left += found[i + 3] < 0;
        for (let k = 0; k < 3; ++k)
          worst = Math.max(worst, Math.abs(found[i + k] - wanted[i + k]));
        ++compared;
      }
      console.log(`${file}: material ${material}, ${found.length / 4} corners, ${worst}`);
      if (!(worst < 2e-4)) throw new Error(`${file}: a tangent is ${worst} off`);
    }
  }
}
if (compared === 0 || left === 0) throw new Error('no tangent, or none of a mirrored texture');
