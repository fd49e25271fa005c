// The library behind planish/c/planish.h for JavaScript: meshes in, surfaces through all of their vertices out.
import makeModule from './planish_library.mjs';
import { PlanishError, refuse } from './error.js';
import { Memory } from './memory.js';

export { PlanishError };

const CODES = {
  1: 'INTERNAL_ERROR', 2: 'INVALID_ARGUMENT', 3: 'UNREADABLE_INPUT', 4: 'UNUSABLE_MESH', 6: 'NO_MEMORY',
  7: 'UNWRITABLE_OUTPUT', 130: 'CANCELLED',
};
const NOT_CONVERGED = 5;

// As the enums of the C header have them.
const CHOICES = {
  method: ['auto', 'progressive', 'fair'],
  scheme: ['doo-sabin', 'catmull-clark', 'loop'],
  weights: ['doo-sabin', 'averaged'],
  solver: ['chebyshev', 'plain', 'cg'],
  boundary: ['edge', 'edge-and-corner'],
  precision: ['auto', 'float', 'double'],
  quads: ['auto', 'on', 'off'],
  stepUnit: ['mm', 'cm', 'm', 'in'],
};
const NUMBERS = {
  tolerance: 'tolerance', maxIterations: 'max_iterations', weld: 'weld', polish: 'polish', stepAngle: 'step_angle',
  stepTolerance: 'step_tolerance', stepFaceSize: 'step_face_size',
};

function settings(options) {
  const values = {};
  for (const [name, value] of Object.entries(options)) {
    if (value === undefined || name === 'progress' || name === 'warning') continue;
    if (name in CHOICES) {
      const choice = CHOICES[name].indexOf(value);
      values[name === 'stepUnit' ? 'step_unit' : name] = choice;
      if (choice < 0) refuse(`${name}: "${value}" is none of ${CHOICES[name].join(', ')}`);
    } else if (name in NUMBERS) {
      if (typeof value !== 'number') refuse(`${name}: a number is wanted, not ${value}`);
      values[NUMBERS[name]] = value;
    } else if (name === 'within') {
      values.within = value === 'auto' ? -1 : value;
    } else if (name === 'repairs') {
      values.repairs = value ? 1 : 0;
    } else if (name === 'creases') {
      values.creases = String(value);
    } else {
      refuse(`"${name}" is no option of a fit`);
    }
  }
  return values;
}

/** Compiles the library. `wasm`: its bytes or module, where they do not lie beside this file. */
export async function load({ wasm } = {}) {
  const given = {};
  if (wasm instanceof WebAssembly.Module) {
    given.instantiateWasm = (imports, done) => {
      WebAssembly.instantiate(wasm, imports).then((instance) => done(instance, wasm));
      return {};
    };
  } else if (wasm) {
    given.wasmBinary = wasm;
  }
  return new Planish(await makeModule(given));
}

class Planish {
  #module;
  constructor(module) {
    this.#module = module;
  }

  get version() {
    return this.#module.UTF8ToString(this.#module._planish_version());
  }

  /** Polygons as arrays, kept in the library: fit() takes them again and again. */
  mesh(arrays) {
    return new Mesh(this.#module, arrays);
  }

  /** A file's mesh; `name` tells its format by its ending. */
  read(bytes, name) {
    const module = this.#module;
    const path = `/read.${String(name).split('.').pop().toLowerCase()}`;
    module.FS.writeFile(path, bytes);
    try {
      return new Memory(module).use((memory) => {
        const handle = memory.out();
        check(module, module._planish_mesh_read(memory.text(path), handle), path, name);
        return new Mesh(module, memory.pointer(handle));
      });
    } finally {
      module.FS.unlink(path);
    }
  }

  /** Fits the surface; an arrays' mesh is taken for this fit only. */
  fit(mesh, options = {}) {
    if (mesh instanceof Mesh) return new Fit(this.#module, mesh, options);
    const made = this.mesh(mesh);
    try {
      return new Fit(this.#module, made, options);
    } finally {
      made.dispose();
    }
  }
}

// Throws unless the status says that there is a result; `path` is called `name` in messages.
function check(module, status, path, name) {
  if (status === 0 || status === NOT_CONVERGED) return status;
  let message = module.UTF8ToString(module._planish_last_error());
  if (path) message = message.replaceAll(path, name);
  throw new PlanishError(message, CODES[status] ?? 'INTERNAL_ERROR', Number(module._planish_last_error_element()));
}

// What is forgotten is freed when it is collected.
const forgotten = new FinalizationRegistry((free) => free());

class Handle {
  constructor(module, pointer, free) {
    this.module = module;
    this.pointer = pointer;
    this.free = () => module[free](pointer);
    forgotten.register(this, this.free, this);
  }

  get alive() {
    if (!this.pointer) refuse('this was disposed of before');
    return this.pointer;
  }

  dispose() {
    if (!this.pointer) return;
    forgotten.unregister(this);
    this.free();
    this.pointer = 0;
  }
}

function flatFaces(faces) {
  if (!Array.isArray(faces) || !faces.every((face) => face && typeof face.length === 'number')) {
    refuse('faces: an array with one array of vertices a face is wanted, or `indices` of triangles');
  }
  return { sizes: faces.map((face) => face.length), vertices: faces.flatMap((face) => [...face]) };
}

// Whole and small enough for int32: typed arrays would cut what is not.
function whole(values, name) {
  for (const value of values)
    if (!Number.isInteger(value) || value < -0x80000000 || value > 0x7fffffff)
      refuse(`${name}: ${value} is no 32-bit integer`);
  return values;
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
function riders(memory, view) {
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

class Mesh extends Handle {
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

function created(module, mesh, options, warnings) {
  return new Memory(module).use((memory) => {
    const values = settings(options);
    if (values.creases !== undefined) values.creases = memory.text(values.creases);
    // An exception must not pass through the library: it cancels, and is thrown after.
    let thrown;
    const guarded = (call) => {
      try {
        return call();
      } catch (error) {
        thrown ??= error;
        return false;
      }
    };
    if (options.progress) {
      values.progress = memory.callback('iiid', (user, step, fraction) =>
        guarded(() => options.progress(module.UTF8ToString(step), fraction)) === false ? 1 : 0);
    }
    values.warning = memory.callback('viii', (user, code, message) => {
      const warning = { code: module.UTF8ToString(code), message: module.UTF8ToString(message) };
      warnings.push(warning);
      if (options.warning) guarded(() => options.warning(warning.code, warning.message));
    });
    const handle = memory.out();
    const status = module._planish_fit_create(mesh.alive, memory.struct('fit_options', values), handle);
    if (thrown) {
      if (status === 0 || status === NOT_CONVERGED) module._planish_fit_free(memory.pointer(handle));
      throw thrown;
    }
    check(module, status);
    return memory.pointer(handle);
  });
}

class Fit extends Handle {
  #queries;
  constructor(module, mesh, options) {
    const warnings = [];
    super(module, created(module, mesh, options, warnings), '_planish_fit_free');
    /** What was mended or noticed: {code, message}. */
    this.warnings = warnings;
    this.info = new Memory(module).use((memory) => {
      const at = memory.struct('fit_info', {});
      check(module, module._planish_fit_get_info(this.alive, at));
      const info = memory.read('fit_info', at);
      return {
        converged: info.converged !== 0, iterations: info.iterations, method: CHOICES.method[info.method],
        maxError: info.max_error, rmsError: info.rms_error, diagonal: info.diagonal,
        vertexCount: info.vertex_count, faceCount: info.face_count, creaseDegrees: info.crease_degrees,
        within: info.within,
      };
    });
  }

  /** The surface after `level` splits of each face, 0 to 6. */
  evaluate(level = 2, { origin } = {}) {
    whole([level], 'level');
    return this.#surface((memory, handle) => this.module._planish_fit_evaluate(this.alive, level, handle), origin);
  }

  /** Triangles as fine as the surface is curved. */
  tessellate({ chordError = 0, angle = 0, origin } = {}) {
    return this.#surface((memory, handle) =>
      this.module._planish_fit_tessellate(this.alive, chordError, angle, handle), origin);
  }

  #surface(make, origin) {
    const { module } = this;
    return new Memory(module).use((memory) => {
      const handle = memory.out();
      check(module, make(memory, handle));
      const surface = memory.pointer(handle);
      try {
        const at = memory.struct('surface_arrays', {});
        check(module, module._planish_surface_view(surface, at));
        return surfaceOf(memory, memory.read('surface_arrays', at), origin);
      } finally {
        module._planish_surface_free(surface);
      }
    });
  }

  /** A file's bytes; `name` tells the format: glb, gltf, obj, ply, off, stl, usda, step. */
  write(name, level = 2) {
    const path = `/${String(name).replace(/.*\//, '')}`;
    whole([level], 'level');
    const { module } = this;
    try {
      new Memory(module).use((memory) =>
        check(module, module._planish_fit_write(this.alive, level, memory.text(path)), path, name));
      return module.FS.readFile(path);
    } finally {
      if (module.FS.analyzePath(path).exists) module.FS.unlink(path);
    }
  }

  glb(level = 2) {
    return this.write('surface.glb', level);
  }

  /** The control cage. */
  cage() {
    const { module } = this;
    return new Memory(module).use((memory) => {
      const handle = memory.out();
      check(module, module._planish_fit_cage(this.alive, handle));
      return new Mesh(module, memory.pointer(handle));
    });
  }

  get #asked() {
    this.#queries ??= new Memory(this.module).use((memory) => {
      const handle = memory.out();
      check(this.module, this.module._planish_queries_create(this.alive, handle));
      return new Handle(this.module, memory.pointer(handle), '_planish_queries_free');
    });
    return this.#queries.alive;
  }

  /** The surface's closest points to x, y, z of each. */
  closest(points) {
    if (points.length % 3 !== 0) refuse(`points: ${points.length} numbers, no multiple of 3`);
    return this.#answers('closest_answers', points.length / 3, { distances: 1 }, (memory, answers) =>
      this.module._planish_queries_closest(this.#asked, memory.f64(points), points.length / 3, answers));
  }

  /** Where each ray first meets the surface; `faces` has -1 where it does not. */
  rays(origins, directions, { tMin = 0, tMax = 1e300 } = {}) {
    if (origins.length % 3 !== 0 || origins.length !== directions.length)
      refuse('origins, directions: x, y, z of each ray are wanted, as many of both');
    return this.#answers('ray_answers', origins.length / 3, { t: 1 }, (memory, answers) =>
      this.module._planish_queries_first_hit(this.#asked, memory.f64(origins), memory.f64(directions),
        origins.length / 3, tMin, tMax, answers));
  }

  #answers(struct, count, further, ask) {
    return new Memory(this.module).use((memory) => {
      const numbers = { positions: 3, normals: 3, ...further };
      const place = memory.layout.place;
      const at = { places: memory.take(count * place.size) };
      for (const [name, width] of Object.entries(numbers)) at[name] = memory.take(8 * width * count);
      check(this.module, ask(memory, memory.struct(struct, at)));
      const result = { faces: new Int32Array(count), places: new Float64Array(2 * count) };
      for (let i = 0; i < count; ++i) {
        const one = memory.read('place', at.places + i * place.size);
        result.faces[i] = one.face;
        result.places.set([one.u, one.v], 2 * i);
      }
      for (const [name, width] of Object.entries(numbers))
        result[name] = memory.copy(Float64Array, at[name], width * count);
      return result;
    });
  }

  dispose() {
    this.#queries?.dispose();
    super.dispose();
  }
}

// The middle of the box, where coordinates are so large that float32 would lose what is small.
function middle(positions) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; ++i) {
    low[i % 3] = Math.min(low[i % 3], positions[i]);
    high[i % 3] = Math.max(high[i % 3], positions[i]);
  }
  return low.map((value, d) => (value + high[d]) / 2);
}

function surfaceOf(memory, view, origin = [0, 0, 0]) {
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
