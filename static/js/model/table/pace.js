// The pace at which the player's own balls are shown to fall: the table's, faster, or instant. Pure.

/** Times as fast as the table's clock. @typedef {"real" | "turbo" | "instant"} Pace @type {Record<Pace, number>} */
export const PACES = { real: 1, turbo: 5, instant: Number.POSITIVE_INFINITY };

/** @typedef {{start: number, end: number, pace: number}} Fall table times, s; end: infinite until it is known */

/** @param {Fall} fall @returns {number} table time at which its landing is shown, s */
export function shownEnd({ start, end, pace }) {
  return pace === 1 ? end : start + (end - start) / pace;
}

/**
 * @param {Fall} fall
 * @param {number} t table time, s
 * @returns {number} the moment of the fall that is shown at `t`, as table time, s
 */
export function timeInFall(fall, t) {
  const { start, end, pace } = fall;
  if (pace === 1 || t <= start) return t;
  const seen = shownEnd(fall);
  // After the landing the ball sinks into its pocket at the table's pace.
  return t < seen ? start + (t - start) * pace : end + (t - seen);
}

/** @param {Fall} fall @param {number} at a moment of the fall, table time, s @returns {number} table time at which it is shown, s */
export function timeSeen({ start, pace }, at) {
  return pace === 1 ? at : start + (at - start) / pace;
}
