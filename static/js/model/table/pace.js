// How fast a ball falls to the eye: our own may be shown sooner than the table's clock has them fall. Pure.

/** Times as fast as the table's clock. @typedef {"real" | "turbo" | "instant"} Pace @type {Record<Pace, number>} */
export const PACES = { real: 1, turbo: 5, instant: Number.POSITIVE_INFINITY };

/** @typedef {{start: number, end: number, pace: number}} Fall table times, s; end: infinite until it is known */

/** @param {Fall} fall @returns {number} table time at which its landing is to be seen, s */
export function shownEnd({ start, end, pace }) {
  return pace === 1 ? end : start + (end - start) / pace;
}

/**
 * @param {Fall} fall
 * @param {number} t table time, s
 * @returns {number} table time at which the ball is where it is shown at `t`, s
 */
export function timeInFall(fall, t) {
  const { start, end, pace } = fall;
  if (pace === 1 || t <= start) return t;
  const seen = shownEnd(fall);
  // Landed, it sinks into its pocket no faster than others do.
  return t < seen ? start + (t - start) * pace : end + (t - seen);
}

/** @param {Fall} fall @param {number} at table time in its fall, s @returns {number} table time at which that is seen, s */
export function timeSeen({ start, pace }, at) {
  return pace === 1 ? at : start + (at - start) / pace;
}
