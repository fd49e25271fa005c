// A fitted surface, and what is asked of it.
import { refuse, whole } from './error.js';
import { Handle, check, isDone } from './handle.js';
import { Memory } from './memory.js';
import { Mesh } from './mesh.js';
import { CHOICES, FitOptions } from './options.js';
import { surfaceOf } from './surface.js';

function created(module, mesh, options, warnings) {
  return new Memory(module).use((memory) => {
    const told = new FitOptions(memory, options, warnings);
    const handle = memory.out();
    const status = module._planish_fit_create(mesh.alive, told.struct, handle);
    try {
      told.end();
    } catch (error) {
      if (isDone(status)) module._planish_fit_free(memory.pointer(handle));
      throw error;
    }
    check(module, status);
    return memory.pointer(handle);
  });
}

/** What a planish_fit_info says. */
export function infoOf(info) {
  return {
    converged: info.converged !== 0, iterations: info.iterations, method: CHOICES.method[info.method],
    maxError: info.max_error, rmsError: info.rms_error, diagonal: info.diagonal,
    vertexCount: info.vertex_count, faceCount: info.face_count, creaseDegrees: info.crease_degrees,
    within: info.within,
  };
}

export class Fit extends Handle {
  #queries;
  constructor(module, mesh, options) {
    const warnings = [];
    super(module, created(module, mesh, options, warnings), '_planish_fit_free');
    /** What was mended or noticed: {code, message}. */
    this.warnings = warnings;
    this.info = new Memory(module).use((memory) => {
      const at = memory.struct('fit_info', {});
      check(module, module._planish_fit_get_info(this.alive, at));
      return infoOf(memory.read('fit_info', at));
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
