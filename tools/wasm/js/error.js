/** `code` is one of the C header's statuses; `element` the face, vertex or byte spoken of, or -1. */
export class PlanishError extends Error {
  constructor(message, code, element = -1) {
    super(message);
    this.name = 'PlanishError';
    this.code = code;
    this.element = element;
  }
}

export function refuse(message) {
  throw new PlanishError(message, 'INVALID_ARGUMENT');
}

/** The values, if they are whole and small enough for int32: typed arrays would cut what is not. */
export function whole(values, name) {
  for (const value of values)
    if (!Number.isInteger(value) || value < -0x80000000 || value > 0x7fffffff)
      refuse(`${name}: ${value} is no 32-bit integer`);
  return values;
}
