// Errors for invalid input; the message names the value and says what is valid.

class InputError extends Error {
  /** @param {string} message @param {string} field the invalid one, such as `pegs[3].radius` */
  constructor(message, field) {
    super(message);
    this.name = new.target.name;
    this.field = field;
  }
}

/** A board has a field that is missing, unknown or out of range. */
export class BoardError extends InputError {}

/** A seed, a start, a time or a scene's parameter is out of range. */
export class ParameterError extends InputError {}

/** A record or a log has a field that is missing, unknown or invalid. */
export class RecordError extends InputError {}
