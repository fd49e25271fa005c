// What a fit is told, as planish_fit_options has it.
import { refuse, whole } from './error.js';

// As the enums of the C header have them.
export const CHOICES = {
  method: ['auto', 'progressive', 'fair'],
  scheme: ['doo-sabin', 'catmull-clark', 'loop'],
  weights: ['doo-sabin', 'averaged'],
  solver: ['chebyshev', 'plain', 'cg'],
  boundary: ['edge', 'edge-and-corner'],
  precision: ['auto', 'float', 'double'],
  quads: ['auto', 'on', 'off'],
  refine: ['auto', 'on', 'off'],
  stepUnit: ['mm', 'cm', 'm', 'in', 'auto'],
};
/** PLANISH_LEVEL_AUTO: 2, of a dense mesh 1. */
export const LEVEL_AUTO = -1;
const NUMBERS = {
  tolerance: 'tolerance', maxIterations: 'max_iterations', weld: 'weld', polish: 'polish', stepAngle: 'step_angle',
  stepTolerance: 'step_tolerance', stepFaceSize: 'step_face_size',
};

// Members of planish_fit_options.
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
    } else if (name === 'coarserLevels') {
      refuse('coarserLevels: they are of fitFile()');
    } else {
      refuse(`"${name}" is no option of a fit`);
    }
  }
  return values;
}

/** Options of a call into the library: what they point to is in its memory, progress() and warning() are
 * heard. An exception of theirs must not pass through the library: it cancels, and end() throws it. */
export class FitOptions {
  #thrown;
  constructor(memory, options, warnings, further = {}) {
    const { module } = memory;
    const values = { ...settings(options), ...further };
    if (values.creases !== undefined) values.creases = memory.text(values.creases);
    const guarded = (call) => {
      try {
        return call();
      } catch (error) {
        this.#thrown ??= error;
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
    this.struct = memory.struct('fit_options', values);
  }

  /** Throws what progress() or warning() has thrown. */
  end() {
    if (this.#thrown) throw this.#thrown;
  }
}

/** The member of planish_fit_options, of levels of detail. */
export function coarserLevels(memory, levels) {
  if (!levels?.length) return {};
  return { coarser_levels: memory.i32(whole(levels, 'coarserLevels')), coarser_level_count: levels.length };
}
