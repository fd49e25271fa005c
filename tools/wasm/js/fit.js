// What a fit is told: options of planish_options_set(), by the names of scene files in camel case, as text. The fitted
// surface, and what is asked of it.
import { Editor, queriesOf } from './editor.js';
import { Handle, Memory, check, isDone, whole } from './memory.js';
import { Mesh, surfaceOf } from './mesh.js';

/** PLANISH_LEVEL_AUTO: what the option `levels` says; else 2, of a dense mesh 1. */
const LEVEL_AUTO = -1;

const nameOf = (key) => key.replace(/[A-Z]/g, (letter) => `_${letter.toLowerCase()}`);

/** Options of a call into the library, for as long as its memory is in use; progress() and warning() are heard. An
 * exception of theirs must not pass through the library: it cancels, and end() throws it. */
export class FitOptions {
  #thrown;
  constructor(memory, { progress, warning, ...options }, warnings) {
    const { module } = memory;
    const handle = memory.out();
    check(module, module._planish_options_create(handle));
    const pointer = memory.pointer(handle);
    memory.atEnd(() => module._planish_options_free(pointer));
    this.pointer = pointer;
    // Lists become texts with commas between.
    for (const [key, value] of Object.entries(options))
      if (value !== undefined)
        check(module, module._planish_options_set(pointer, memory.text(nameOf(key)), memory.text(String(value))));
    const guarded = (call) => {
      try {
        return call();
      } catch (error) {
        this.#thrown ??= error;
        return false;
      }
    };
    if (progress) {
      module._planish_options_on_progress(pointer, memory.callback('iiid', (user, step, fraction) =>
        guarded(() => progress(module.UTF8ToString(step), fraction)) === false ? 1 : 0), 0);
    }
    module._planish_options_on_warning(pointer, memory.callback('viii', (user, code, message) => {
      const told = { code: module.UTF8ToString(code), message: module.UTF8ToString(message) };
      warnings.push(told);
      if (warning) guarded(() => warning(told.code, told.message));
    }), 0);
  }

  /** Throws what progress() or warning() has thrown. */
  end() {
    if (this.#thrown) throw this.#thrown;
  }
}

function created(module, mesh, options, warnings) {
  return new Memory(module).use((memory) => {
    const told = new FitOptions(memory, options, warnings);
    const handle = memory.out();
    const status = module._planish_fit_create(mesh.alive, told.pointer, handle);
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
export function infoOf(module, info) {
  return {
    converged: info.converged !== 0, iterations: info.iterations, interpolation: module.UTF8ToString(info.interpolation),
    maxError: info.max_error, rmsError: info.rms_error, diagonal: info.diagonal,
    vertexCount: info.vertex_count, faceCount: info.face_count, creaseDegrees: info.crease_degrees,
    findsFeatures: info.finds_features !== 0,
    within: info.within,
  };
}

export function fitted(module, mesh, options) {
  const warnings = [];
  return new Fit(module, created(module, mesh, options, warnings), warnings);
}

export class Fit extends Handle {
  #queries;
  constructor(module, pointer, warnings) {
    super(module, pointer, '_planish_fit_free');
    /** What was mended or noticed: {code, message}. */
    this.warnings = warnings;
    this.info = new Memory(module).use((memory) => {
      const at = memory.struct('fit_info', {});
      check(module, module._planish_fit_get_info(this.alive, at));
      return infoOf(module, memory.read('fit_info', at));
    });
  }

  /** The surface after `level` splits of each face, 0 to 6; without one as `levels` says, else 2, of a dense mesh 1. */
  evaluate(level = LEVEL_AUTO, { origin } = {}) {
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
  write(name, level = LEVEL_AUTO) {
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

  glb(level = LEVEL_AUTO) {
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
    this.#queries ??= queriesOf(this, '_planish_queries_create');
    return this.#queries;
  }

  /** The surface's closest points to x, y, z of each. */
  closest(points) {
    return this.#asked.closest(points);
  }

  /** Where each ray first meets the surface; `faces` has -1 where it does not. */
  rays(origins, directions, range) {
    return this.#asked.rays(origins, directions, range);
  }

  /** Moves vertices of this mesh, and keeps the rows of evaluate(level) right. */
  edit(level = LEVEL_AUTO, { origin } = {}) {
    return new Editor(this, whole([level], 'level')[0], origin, (pointer) => new Fit(this.module, pointer, []));
  }

  dispose() {
    this.#queries?.dispose();
    super.dispose();
  }
}
