// Surfaces as typed arrays, to draw.
import { riders } from './mesh.js';

// The middle of the box, where coordinates are so large that float32 would lose what is small.
export function middle(positions) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; ++i) {
    low[i % 3] = Math.min(low[i % 3], positions[i]);
    high[i % 3] = Math.max(high[i % 3], positions[i]);
  }
  return low.map((value, d) => (value + high[d]) / 2);
}

/** What a planish_surface_arrays holds. */
export function surfaceOf(memory, view, origin = [0, 0, 0]) {
  const exact = memory.copy(Float64Array, view.positions, 3 * view.vertex_count);
  const corners = memory.copy(Uint32Array, view.face_vertices, view.corner_count);
  const offsets = view.face_offsets
    ? memory.copy(Uint32Array, view.face_offsets, view.face_count + 1)
    : Uint32Array.from({ length: view.face_count + 1 }, (_, face) => 4 * face);
  const from = origin === 'center' ? middle(exact) : [...origin];
  const triangleCorners = triangles(exact, corners, offsets);
  return {
    positions: Float32Array.from(exact, (value, i) => value - from[i % 3]),
    origin: from,
    normals: memory.copy(Float32Array, view.normals, 3 * view.vertex_count),
    indices: triangleCorners.map((corner) => corners[corner]),
    triangleCorners, faceVertices: corners, faceOffsets: offsets,
    baseVertices: memory.copy(Int32Array, view.base_vertices, view.base_count),
    ...riders(memory, view),
  };
}

// Corners of the faces that make triangles: quads by the shorter diagonal, others as fans.
function triangles(positions, corners, offsets) {
  const result = new Uint32Array(3 * (corners.length - 2 * (offsets.length - 1)));
  const gap = (a, b) => {
    let sum = 0;
    for (let d = 0; d < 3; ++d) sum += (positions[3 * corners[a] + d] - positions[3 * corners[b] + d]) ** 2;
    return sum;
  };
  let at = 0;
  for (let face = 0; face + 1 < offsets.length; ++face) {
    const first = offsets[face], size = offsets[face + 1] - first;
    const turn = size === 4 && gap(first + 1, first + 3) < gap(first, first + 2) ? 1 : 0;
    for (let i = 1; i + 1 < size; ++i) {
      result[at++] = first + turn;
      result[at++] = first + ((i + turn) % size);
      result[at++] = first + ((i + 1 + turn) % size);
    }
  }
  return result;
}
