// The payout of a stake in whole minor units, rounded down. The multiplier counts as the decimal that is written.

/**
 * @param {number} stake whole minor units
 * @param {number} score the multiplier: 0.1 of 10 is exactly 1
 * @returns {number}
 */
export function payoutOf(stake, score) {
  const [mantissa, exponent = "0"] = String(score).split("e");
  const [whole, fraction = ""] = mantissa.split(".");
  const power = Number(exponent) - fraction.length;
  const units = BigInt(whole + fraction) * BigInt(stake);
  return Number(power < 0 ? units / 10n ** BigInt(-power) : units * 10n ** BigInt(power));
}
