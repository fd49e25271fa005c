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
