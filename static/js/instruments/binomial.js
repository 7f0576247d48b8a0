// How often each bin should be hit, where theory has an answer. Pure.

/** @import { Expectation } from "./histogram.js" */

/**
 * @param {number} rows
 * @returns {number[]} probabilities of 0 … rows successes in `rows` fair trials
 */
function binomial(rows) {
  const chances = [0.5 ** rows];
  for (let k = 1; k <= rows; k += 1) chances.push((chances[k - 1] * (rows - k + 1)) / k);
  return chances;
}

/**
 * @param {string} name of the board
 * @param {number} bins
 * @returns {Expectation | null} null where no simple law is claimed
 */
export function expectedOf(name, bins) {
  if (!/^triangle-\d+/.test(name)) return null;
  return { label: `binomial, ${bins - 1} fair rows`, chances: binomial(bins - 1) };
}
