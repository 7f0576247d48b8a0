// The payout of a stake in whole minor units, rounded down. The multiplier counts as the decimal that is written.

/** The largest payout in minor units: a double keeps it and all smaller ones exactly. */
export const MOST_PAYOUT = Number.MAX_SAFE_INTEGER;

/** @param {number[]} multipliers of a board @returns {number} the largest stake that a server accepts there, minor units */
export function mostStake(multipliers) {
  const [whole, power] = decimalOf(Math.max(...multipliers));
  if (whole === 0n) return MOST_PAYOUT;
  const [up, down] = power < 0 ? [10n ** BigInt(-power), 1n] : [1n, 10n ** BigInt(power)];
  const stake = ((BigInt(MOST_PAYOUT) + 1n) * up - 1n) / (whole * down);
  return Math.min(Number(stake), MOST_PAYOUT);
}

/** @param {number} value @returns {[bigint, number]} the value as it is written: a whole number times a power of ten */
function decimalOf(value) {
  const [mantissa, exponent = "0"] = String(value).split("e");
  const [whole, fraction = ""] = mantissa.split(".");
  return [BigInt(whole + fraction), Number(exponent) - fraction.length];
}

/**
 * @param {number} stake whole minor units
 * @param {number} score the multiplier: 0.1 of 10 is exactly 1
 * @returns {bigint}
 */
export function exactPayout(stake, score) {
  const [whole, power] = decimalOf(score);
  const units = whole * BigInt(stake);
  return power < 0 ? units / 10n ** BigInt(-power) : units * 10n ** BigInt(power);
}

/** @param {number} stake whole minor units @param {number} score @returns {number} exact up to MOST_PAYOUT */
export function payoutOf(stake, score) {
  return Number(exactPayout(stake, score));
}
