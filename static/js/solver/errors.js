// What is wrong with what a caller gave; the message names the value and what would be right.

/** A board that cannot be played, or a drop that cannot be made. */
class InputError extends Error {
  /** @param {string} message @param {string} field where the bad value is, as `pegs[3].radius` */
  constructor(message, field) {
    super(message);
    this.name = new.target.name;
    this.field = field;
  }
}

/** A board with a value that is missing, unknown or out of range. */
export class BoardError extends InputError {}

/** A seed, a start or a time that is out of range. */
export class ParameterError extends InputError {}

/** A record or a log that lacks something, or has what nothing would compare. */
export class RecordError extends InputError {}
