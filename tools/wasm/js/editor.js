// Questions to a surface. A fitted mesh whose vertices move: only what they reach is solved and evaluated again.
import { Handle, Memory, check, refuse, whole } from './memory.js';
import { middle } from './mesh.js';

/** Of a Fit or Editor, by the library's function that makes them. */
export function queriesOf(asked, create) {
  const { module } = asked;
  return new Memory(module).use((memory) => {
    const handle = memory.out();
    check(module, module[create](asked.alive, handle));
    return new Queries(module, memory.pointer(handle), '_planish_queries_free');
  });
}

class Queries extends Handle {
  closest(points) {
    if (points.length % 3 !== 0) refuse(`points: ${points.length} numbers, no multiple of 3`);
    return this.#answers('closest_answers', points.length / 3, { distances: 1 }, (memory, answers) =>
      this.module._planish_queries_closest(this.alive, memory.f64(points), points.length / 3, answers));
  }

  rays(origins, directions, { tMin = 0, tMax = 1e300 } = {}) {
    if (origins.length % 3 !== 0 || origins.length !== directions.length)
      refuse('origins, directions: x, y, z of each ray are wanted, as many of both');
    return this.#answers('ray_answers', origins.length / 3, { t: 1 }, (memory, answers) =>
      this.module._planish_queries_first_hit(this.alive, memory.f64(origins), memory.f64(directions),
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
}

function created(fit, level) {
  return new Memory(fit.module).use((memory) => {
    const handle = memory.out();
    check(fit.module, fit.module._planish_editor_create(fit.alive, level, handle));
    return memory.pointer(handle);
  });
}

export class Editor extends Handle {
  #queries;
  #fitOf;
  /** `fitOf` makes a Fit of the library's. */
  constructor(fit, level, origin = [0, 0, 0], fitOf) {
    super(fit.module, created(fit, level), '_planish_editor_free');
    this.#fitOf = fitOf;
    /** Taken from positions before they become float32, for good. */
    this.origin = origin === 'center' ? this.#viewed((memory, view) =>
      middle(memory.copy(Float64Array, view.positions, 3 * view.row_count))) : [...origin];
  }

  #viewed(look) {
    return new Memory(this.module).use((memory) => {
      const at = memory.struct('editor_arrays', {});
      check(this.module, this.module._planish_editor_view(this.alive, at));
      return look(memory, memory.read('editor_arrays', at));
    });
  }

  /** Where the mesh's vertices are now. */
  get points() {
    return this.#viewed((memory, view) => memory.copy(Float64Array, view.points, 3 * view.point_count));
  }

  get state() {
    return this.#viewed((memory, view) =>
      ({ errorBound: view.error_bound, canUndo: view.can_undo !== 0, canRedo: view.can_redo !== 0 }));
  }

  #rowsOf(memory, view, first, count) {
    const exact = memory.copy(Float64Array, view.positions + 24 * first, 3 * count);
    return {
      first, count,
      positions: Float32Array.from(exact, (value, k) => value - this.origin[k % 3]),
      normals: memory.copy(Float32Array, view.normals + 12 * first, 3 * count),
    };
  }

  /** All rows as they are now. */
  rows() {
    return this.#viewed((memory, view) => this.#rowsOf(memory, view, 0, view.row_count));
  }

  // What a call has changed: the vertices, and the rows of the surface's arrays.
  #changed(call) {
    return new Memory(this.module).use((memory) => {
      const at = memory.struct('edit_change', {});
      check(this.module, call(memory, at));
      const change = memory.read('edit_change', at);
      const { size } = memory.layout.row_range;
      const rows = this.#viewed((inner, view) => Array.from({ length: change.range_count }, (_, i) => {
        const { first, count } = inner.read('row_range', change.rows + i * size);
        return this.#rowsOf(inner, view, first, count);
      }));
      return {
        vertices: memory.copy(Int32Array, change.vertices, change.vertex_count), rows, isWhole: change.is_whole !== 0,
      };
    });
  }

  /** Moves vertices to x, y, z of each. */
  move(vertices, positions) {
    if (positions.length !== 3 * vertices.length) refuse(`positions: x, y, z of ${vertices.length} vertices are wanted`);
    return this.#changed((memory, change) => this.module._planish_editor_move(this.alive,
      memory.i32(whole(vertices, 'vertices')), memory.f64(positions), vertices.length, change));
  }

  /** The vertices within `radius` of some others along edges, and weights that fall from 1 there to 0. */
  select(vertices, radius) {
    return new Memory(this.module).use((memory) => {
      const [selected, weights, count] = [memory.out(), memory.out(), memory.out()];
      check(this.module, this.module._planish_editor_select(this.alive, memory.i32(whole(vertices, 'vertices')),
        vertices.length, radius, selected, weights, count));
      const length = memory.pointer(count);
      return {
        vertices: memory.copy(Int32Array, memory.pointer(selected), length),
        weights: memory.copy(Float64Array, memory.pointer(weights), length),
      };
    });
  }

  /** Moves what select() gives by an affine map: three rows of four numbers; without weights all the way. */
  transform({ vertices, weights }, matrix) {
    if (matrix.length !== 12) refuse('matrix: three rows of four numbers are wanted');
    if (weights && weights.length !== vertices.length) refuse('weights: one a vertex is wanted');
    return this.#changed((memory, change) => this.module._planish_editor_transform(this.alive,
      memory.i32(whole(vertices, 'vertices')), weights ? memory.f64(weights) : 0, vertices.length, memory.f64(matrix),
      change));
  }

  /** Makes edges (pairs of vertices) and corners sharp, or smooth again. */
  setSharp({ edges = [], corners = [], sharp = true }) {
    const pairs = whole([...edges].flat(), 'edges');
    if (pairs.length % 2 !== 0) refuse('edges: pairs of vertices are wanted');
    this.#forget();
    return this.#changed((memory, change) => this.module._planish_editor_set_sharp(this.alive, memory.i32(pairs),
      pairs.length / 2, memory.i32(whole(corners, 'corners')), corners.length, sharp ? 1 : 0, change));
  }

  undo() {
    return this.#changed((_, change) => this.module._planish_editor_undo(this.alive, change));
  }

  redo() {
    return this.#changed((_, change) => this.module._planish_editor_redo(this.alive, change));
  }

  /** Solves the whole mesh from where it is. */
  settle() {
    return this.#changed((_, change) => this.module._planish_editor_settle(this.alive, change));
  }

  /** Makes what a fit makes of the mesh as it is now, with all that it decides. */
  refit() {
    this.#forget();
    return this.#changed((_, change) => this.module._planish_editor_refit(this.alive, change));
  }

  /** The mesh and its surface as they are now. */
  fit() {
    return new Memory(this.module).use((memory) => {
      const handle = memory.out();
      check(this.module, this.module._planish_editor_fit(this.alive, handle));
      return this.#fitOf(memory.pointer(handle));
    });
  }

  get #asked() {
    this.#queries ??= queriesOf(this, '_planish_editor_queries');
    return this.#queries;
  }

  /** As of a Fit, of the surface as it is now. */
  closest(points) {
    return this.#asked.closest(points);
  }

  rays(origins, directions, range) {
    return this.#asked.rays(origins, directions, range);
  }

  // They answer for the surface as it was.
  #forget() {
    this.#queries?.dispose();
    this.#queries = undefined;
  }

  dispose() {
    this.#forget();
    super.dispose();
  }
}
