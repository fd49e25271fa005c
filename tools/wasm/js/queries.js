// Questions to a surface.
import { refuse } from './error.js';
import { Handle, check } from './handle.js';
import { Memory } from './memory.js';

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
