// The exact odds of a draw, in words ("1 in 10,000"). Pure.

import { language, t } from "../texts/text.js";

/**
 * @param {number[]} weights of the bins, left to right
 * @returns {{bin: number, words: string}[]} the bins with a weight above 0, and their exact odds
 */
export function drawOdds(weights) {
  const sum = weights.reduce((total, weight) => total + BigInt(weight), 0n);
  return weights.flatMap((weight, bin) => (weight === 0 ? [] : [{ bin, words: chance(BigInt(weight), sum) }]));
}

/** @param {bigint} weight above 0 @param {bigint} sum @returns {string} "1 in 10,000" */
function chance(weight, sum) {
  const common = divisor(weight, sum);
  return t("draw.chance", { part: shown(weight / common), whole: shown(sum / common) });
}

/** @param {bigint} a @param {bigint} b @returns {bigint} the greatest common divisor */
const divisor = (a, b) => (b === 0n ? a : divisor(b, a % b));

/** @param {bigint} value */
const shown = (value) => value.toLocaleString(language);
