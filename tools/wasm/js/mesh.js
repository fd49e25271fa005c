// Meshes: polygons as arrays to the library and back. Surfaces as typed arrays, to draw.
import { Handle, Memory, check, refuse, whole } from './memory.js';

function flatFaces(faces) {
  if (!Array.isArray(faces) || !faces.every((face) => face && typeof face.length === 'number')) {
    refuse('faces: an array with one array of vertices a face is wanted, or `indices` of triangles');
  }
  return { sizes: faces.map((face) => face.length), vertices: faces.flatMap((face) => [...face]) };
}

function made(module, arrays) {
  return new Memory(module).use((memory) => {
    if (!arrays || !arrays.positions) refuse('a mesh has `positions`: x, y, z of each vertex');
    if (arrays.positions.length % 3 !== 0) refuse(`positions: ${arrays.positions.length} numbers, no multiple of 3`);
    const values = { positions: memory.f64(arrays.positions), vertex_count: arrays.positions.length / 3 };
    if (arrays.indices) {
      if (arrays.indices.length % 3 !== 0) refuse(`indices: ${arrays.indices.length} numbers, no multiple of 3`);
      Object.assign(values, {
        corners_per_face: 3, face_count: arrays.indices.length / 3,
        face_vertices: memory.i32(whole(arrays.indices, 'indices')), corner_count: arrays.indices.length,
      });
    } else {
      const { sizes, vertices } = arrays.faceSizes
        ? { sizes: arrays.faceSizes, vertices: arrays.faceVertices ?? [] } : flatFaces(arrays.faces);
      Object.assign(values, {
        face_sizes: memory.i32(whole(sizes, 'sizes of faces')), face_count: sizes.length,
        face_vertices: memory.i32(whole(vertices, 'faces')), corner_count: vertices.length,
      });
    }
    if (arrays.creases) {
      const pairs = arrays.creases.flat ? arrays.creases.flat() : arrays.creases;
      if (pairs.length % 2 !== 0) refuse('creases: pairs of vertices are wanted');
      values.crease_edges = memory.i32(whole(pairs, 'creases'));
      values.crease_count = pairs.length / 2;
    }
    if (arrays.corners) {
      values.corner_vertices = memory.i32(whole(arrays.corners, 'corners'));
      values.sharp_corner_count = arrays.corners.length;
    }
    if (arrays.uvs) {
      if (arrays.faceUvs?.length !== values.corner_count) refuse('faceUvs: one number a corner of the faces is wanted');
      Object.assign(values, { uvs: memory.f64(arrays.uvs), uv_count: arrays.uvs.length / 2,
        face_uvs: memory.i32(whole(arrays.faceUvs, 'faceUvs')) });
    }
    if (arrays.colors) {
      if (arrays.colors.length !== 4 * values.vertex_count) refuse('colors: R, G, B, A of each vertex are wanted');
      values.colors = memory.f32(arrays.colors);
    }
    if (arrays.groups) {
      if (arrays.faceGroups?.length !== values.face_count) refuse('faceGroups: one number a face is wanted');
      Object.assign(values, {
        group_names: memory.texts(arrays.groups.map((group) => group.name)),
        group_materials: memory.texts(arrays.groups.map((group) => group.material ?? '')),
        group_count: arrays.groups.length, face_groups: memory.i32(whole(arrays.faceGroups, 'faceGroups')),
      });
    }
    const handle = memory.out();
    check(module, module._planish_mesh_create(memory.struct('mesh_arrays', values), handle));
    return memory.pointer(handle);
  });
}

/** What an array view of the library has besides positions and faces. */
export function riders(memory, view) {
  const corners = view.corner_count;
  const result = {};
  if (view.face_uvs) {
    result.uvs = memory.copy(Float64Array, view.uvs, 2 * view.uv_count);
    result.faceUvs = memory.copy(Int32Array, view.face_uvs, corners);
  }
  if (view.colors) result.colors = memory.copy(Float32Array, view.colors, 4 * view.vertex_count);
  if (view.group_count) {
    const names = memory.readTexts(view.group_names, view.group_count);
    const materials = memory.readTexts(view.group_materials, view.group_count);
    result.groups = names.map((name, i) => ({ name, material: materials[i] }));
    result.faceGroups = memory.copy(Int32Array, view.face_groups, view.face_count);
  }
  return result;
}

export class Mesh extends Handle {
  constructor(module, source) {
    super(module, typeof source === 'number' ? source : made(module, source), '_planish_mesh_free');
  }

  /** A copy as arrays. */
  arrays() {
    return new Memory(this.module).use((memory) => {
      const at = memory.struct('mesh_arrays', {});
      check(this.module, this.module._planish_mesh_view(this.alive, at));
      const view = memory.read('mesh_arrays', at);
      return {
        positions: memory.copy(Float64Array, view.positions, 3 * view.vertex_count),
        faceSizes: memory.copy(Int32Array, view.face_sizes, view.face_count),
        faceVertices: memory.copy(Int32Array, view.face_vertices, view.corner_count),
        ...riders(memory, view),
      };
    });
  }
}

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
