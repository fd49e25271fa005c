// BufferGeometry of three.js in and out.
import { BufferAttribute, BufferGeometry } from 'three';

/**
 * A geometry's mesh, for fit(). Loaders give a vertex several times where its normal or texture coordinates differ:
 * equal positions become one. Groups keep the materials of their faces; normals are left behind.
 */
export function fromGeometry(geometry) {
  const position = geometry.getAttribute('position');
  const uv = geometry.getAttribute('uv');
  const color = geometry.getAttribute('color');
  const known = new Map();
  const positions = [], colors = [];
  const welded = new Int32Array(position.count);
  for (let i = 0; i < position.count; ++i) {
    // 0 and -0 are one place.
    const place = [position.getX(i) + 0, position.getY(i) + 0, position.getZ(i) + 0];
    const key = place.join(' ');
    if (!known.has(key)) {
      known.set(key, known.size);
      positions.push(...place);
      if (color) colors.push(color.getX(i), color.getY(i), color.getZ(i), color.itemSize > 3 ? color.getW(i) : 1);
    }
    welded[i] = known.get(key);
  }
  const index = geometry.getIndex();
  const count = index ? index.count : position.count;
  const groups = geometry.groups.length ? geometry.groups : [{ start: 0, count, materialIndex: 0 }];
  const indices = [], faceUvs = [], faceGroups = [];
  groups.forEach((group, number) => {
    const end = Math.min(count, group.start + group.count);
    for (let i = group.start; i + 2 < end; i += 3) {
      const named = [0, 1, 2].map((k) => (index ? index.getX(i + k) : i + k));
      const [a, b, c] = named.map((vertex) => welded[vertex]);
      if (a === b || b === c || c === a) continue;
      indices.push(a, b, c);
      faceGroups.push(number);
      faceUvs.push(...named);
    }
  });
  const mesh = { positions, indices };
  if (color) mesh.colors = colors;
  if (uv) {
    const known = new Map(), uvs = [];
    mesh.faceUvs = faceUvs.map((vertex) => {
      const key = `${uv.getX(vertex)} ${uv.getY(vertex)}`;
      if (!known.has(key)) {
        known.set(key, known.size);
        uvs.push(uv.getX(vertex), uv.getY(vertex));
      }
      return known.get(key);
    });
    mesh.uvs = uvs;
  }
  if (geometry.groups.length) {
    mesh.groups = groups.map((group, i) => ({ name: `group${i}`, material: String(group.materialIndex ?? 0) }));
    mesh.faceGroups = faceGroups;
  }
  return mesh;
}

/** What evaluate() and tessellate() give, to draw. Put the object at the surface's `origin`. */
export function toGeometry(surface) {
  const geometry = new BufferGeometry();
  const { triangleCorners, faceVertices } = surface;
  // By group, so that each is one range.
  let order = triangleCorners;
  if (surface.groups) {
    const faceOf = new Int32Array(faceVertices.length);
    for (let face = 0; face + 1 < surface.faceOffsets.length; ++face)
      faceOf.fill(face, surface.faceOffsets[face], surface.faceOffsets[face + 1]);
    const groupOf = (triangle) => surface.faceGroups[faceOf[triangleCorners[3 * triangle]]];
    const triangles = Array.from({ length: triangleCorners.length / 3 }, (_, i) => i);
    triangles.sort((a, b) => groupOf(a) - groupOf(b));
    order = Uint32Array.from({ length: triangleCorners.length },
      (_, i) => triangleCorners[3 * triangles[Math.floor(i / 3)] + (i % 3)]);
    let start = 0;
    triangles.forEach((triangle, i) => {
      const group = groupOf(triangle);
      if (i + 1 < triangles.length && groupOf(triangles[i + 1]) === group) return;
      const material = Number(surface.groups[group]?.material);
      geometry.addGroup(3 * start, 3 * (i + 1 - start), Number.isInteger(material) ? material : Math.max(group, 0));
      start = i + 1;
    });
  }
  // A vertex is given once for each of its texture coordinates.
  const vertices = [], uvs = [];
  const indices = new Uint32Array(order.length);
  if (surface.faceUvs) {
    const known = new Map();
    order.forEach((corner, i) => {
      const vertex = faceVertices[corner], uv = surface.faceUvs[corner];
      const key = vertex * (surface.uvs.length / 2 + 1) + uv + 1;
      if (!known.has(key)) {
        known.set(key, vertices.length);
        vertices.push(vertex);
        uvs.push(uv < 0 ? 0 : surface.uvs[2 * uv], uv < 0 ? 0 : surface.uvs[2 * uv + 1]);
      }
      indices[i] = known.get(key);
    });
    geometry.setAttribute('uv', new BufferAttribute(new Float32Array(uvs), 2));
  } else {
    order.forEach((corner, i) => (indices[i] = faceVertices[corner]));
  }
  const taken = (values, width) => {
    if (!surface.faceUvs) return new BufferAttribute(values, width);
    const result = new Float32Array(width * vertices.length);
    vertices.forEach((vertex, i) => result.set(values.subarray(width * vertex, width * (vertex + 1)), width * i));
    return new BufferAttribute(result, width);
  };
  geometry.setAttribute('position', taken(surface.positions, 3));
  geometry.setAttribute('normal', taken(surface.normals, 3));
  if (surface.colors) geometry.setAttribute('color', taken(surface.colors, 4));
  geometry.setIndex(new BufferAttribute(indices, 1));
  return geometry;
}
