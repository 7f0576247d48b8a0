// What a stake comes back as: whole minor units, rounded down, the multiplier as it is written.

/**
 * @param {number} stake whole minor units
 * @param {number} score multiplier: 0.1 of 10 is 1
 * @returns {number}
 */
export function payoutOf(stake, score) {
  const [mantissa, exponent = "0"] = String(score).split("e");
  const [whole, fraction = ""] = mantissa.split(".");
  const power = Number(exponent) - fraction.length;
  const units = BigInt(whole + fraction) * BigInt(stake);
  return Number(power < 0 ? units / 10n ** BigInt(-power) : units * 10n ** BigInt(power));
}
