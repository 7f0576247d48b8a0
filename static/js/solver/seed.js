// Computes the start of a drop from its seed, by SplitMix64. Nothing else about a drop is random.

import { ParameterError } from "./errors.js";

const LIMIT = 1n << 64n;
const MASK = LIMIT - 1n;
const GAMMA = 0x9e3779b97f4a7c15n;
const MIX_1 = 0xbf58476d1ce4e5b9n;
const MIX_2 = 0x94d049bb133111ebn;
const UNIT = 2 ** -53;

/**
 * A seed as a BigInt. A Number of 2^53 or more is refused, because JavaScript may have rounded it.
 * @param {unknown} value a decimal string, a BigInt or a Number
 * @returns {bigint} 0 … 2^64 - 1; throws a ParameterError otherwise
 */
export function seedOf(value) {
  const digits = typeof value === "string" && /^[0-9]{1,20}$/.test(value);
  const exact = typeof value === "bigint" || Number.isSafeInteger(value);
  const seed = digits || exact ? BigInt(/** @type {string} */ (value)) : -1n;
  if (seed >= 0n && seed < LIMIT) return seed;
  throw new ParameterError(`seed ${String(value)} is not a whole number from 0 to 2^64 - 1`, "seed");
}

/** @param {bigint} seed @returns {bigint} first output of SplitMix64 */
export function splitmix64(seed) {
  let z = (seed + GAMMA) & MASK;
  z = ((z ^ (z >> 30n)) * MIX_1) & MASK;
  z = ((z ^ (z >> 27n)) * MIX_2) & MASK;
  return z ^ (z >> 31n);
}

/**
 * @param {bigint} seed
 * @param {number} x m
 * @param {number} jitter m
 * @returns {number} where the ball starts: x plus a uniform offset in [-jitter, jitter), m
 */
export function startX(seed, x, jitter) {
  const fraction = Number(splitmix64(seed) >> 11n) * UNIT;
  return x + jitter * (2 * fraction - 1);
}
