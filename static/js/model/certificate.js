// What the server has proven of a drop, in words, and where two proven paths part. Pure.

/**
 * @typedef {{low: number, high: number, text: string}} Enclosed
 * @typedef {[kind: number, index: number, t: number, x: number, y: number, error: number]} ProvenEvent
 */

/**
 * @typedef {object} Certificate of a drop, as REST has it
 * @property {boolean} certified
 * @property {number | null} bin
 * @property {string | null} unsettled
 * @property {string | null} undecided
 * @property {Enclosed | null} x_end
 * @property {Enclosed | null} duration
 * @property {number} impacts
 * @property {number} bits
 * @property {number} comparisons
 * @property {string[]} ties
 * @property {boolean | null} agrees
 * @property {ProvenEvent[]} events
 */

const PEG = 0;
const WALL = 1;

/** @param {Certificate} certificate @returns {string} */
export function provenWords({ certified, bin, unsettled, undecided, ...rest }) {
  if (!certified) return `Not proven: it stays open ${undecided}.`;
  const { x_end: x, duration, bits, comparisons, ties, agrees } = rest;
  const how = `${comparisons} comparisons, each decided with ${bits} bits`;
  const tied = ties.length ? ` At the same instant: ${ties.join("; ")}.` : "";
  const other = agrees ? "Double precision has it right." : "Double precision has another.";
  const where = bin === null
    ? `Proven: no bin, ${unsettled}`
    : `Certified: bin ${bin}, x = ${x?.text} m after ${duration?.text} s`;
  return `${where}; ${how}.${tied} ${other}`;
}

/**
 * Where two proven paths go different ways.
 * @param {Certificate} one
 * @param {Certificate} two
 * @returns {{common: number, apart: number, error: number} | null} common: events they share;
 *   apart: how far the balls are from each other at the last of these, m, within error; null if
 *   they never part
 */
export function partingOf(one, two) {
  const count = Math.max(one.events.length, two.events.length);
  for (let i = 0; i < count; i += 1) {
    const [a, b] = [one.events[i], two.events[i]];
    if (a && b && a[0] === b[0] && a[1] === b[1]) continue;
    if (i === 0) return { common: 0, apart: 0, error: 0 };
    const [before, beside] = [one.events[i - 1], two.events[i - 1]];
    return {
      common: i,
      apart: Math.hypot(before[3] - beside[3], before[4] - beside[4]),
      error: Math.SQRT2 * (before[5] + beside[5]),
    };
  }
  return null;
}

/** @param {ProvenEvent | undefined} event @returns {string} what the ball does there */
export function eventWords(event) {
  if (!event) return "has ended";
  const [kind, index] = event;
  if (kind === PEG) return `hits peg ${index}`;
  if (kind === WALL) return `hits wall ${index}`;
  return ["begins to roll or slide", "changes how it moves", "leaves", `lands in bin ${index}`][kind - 2];
}

/** @param {Certificate} one @param {Certificate} two @returns {string} */
export function partingWords(one, two) {
  if (!one.certified || !two.certified) {
    const open = one.certified ? two : one;
    return provenWords(open);
  }
  const parting = partingOf(one, two);
  if (!parting) return `Proven: both go the same way to the end, bin ${one.bin}.`;
  const { common, apart, error } = parting;
  const far = common === 0 ? "" : ` There they were ${apart.toExponential(1)} m apart, within ${error.toExponential(0)} m.`;
  const then = `the first ${eventWords(one.events[common])}, the second ${eventWords(two.events[common])}`;
  return `Proven: ${common} events are common to both, then ${then}.${far}`;
}
