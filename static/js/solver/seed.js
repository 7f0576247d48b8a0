// Computes where a ball starts: at an explicit x, or where the seed draws it around the zone's x or an aim, by
// SplitMix64. Nothing else about a drop is random.

import { ParameterError } from "./errors.js";

/** @import { WholeBoard } from "./input/values.js" */

/** @typedef {WholeBoard["drop"]} Zone */
/** @typedef {{x: number, explicit: boolean, aim: number | null}} Place x: the start, m */

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
function startX(seed, x, jitter) {
  const fraction = Number(splitmix64(seed) >> 11n) * UNIT;
  return x + jitter * (2 * fraction - 1);
}

/**
 * @param {Zone} zone
 * @param {bigint | null} seed
 * @param {{x?: unknown, aim?: unknown}} chosen m
 * @returns {Place} throws a ParameterError that names an invalid value
 */
export function startOf(zone, seed, { x, aim }) {
  if (!isGiven(x)) {
    if (seed === null) throw new ParameterError("a drop needs a seed or an explicit x", "seed");
    const middle = isGiven(aim) ? aimOf(zone, aim) : null;
    return { x: startX(seed, middle ?? zone.x, zone.jitter), explicit: false, aim: middle };
  }
  if (isGiven(aim)) {
    throw new ParameterError(
      `aim is ${String(aim)}, but x is ${String(x)}: give either x, the exact start, or an aim, around `
      + "which the seed draws it", "aim",
    );
  }
  const span = spanOf(zone);
  const low = Math.min(zone.x - span, ...zone.slots);
  const high = Math.max(zone.x + span, ...zone.slots);
  return { x: within(x, "x", low, high), explicit: true, aim: null };
}

/**
 * @param {Zone} zone
 * @param {Iterable<string | bigint | number>} seeds
 * @param {number | null} aim m, the same for all
 * @returns {Float64Array} where each ball starts, m
 */
export function startsOf(zone, seeds, aim) {
  const middle = isGiven(aim) ? aimOf(zone, aim) : zone.x;
  return Float64Array.from(seeds, (seed) => startX(seedOf(seed), middle, zone.jitter));
}

/** @param {Zone} zone @param {unknown} aim @returns {number} the checked aim, m */
function aimOf(zone, aim) {
  const span = Math.min(zone.aim, spanOf(zone) - zone.jitter);
  const middle = within(aim, "aim", zone.x - span, zone.x + span) + 0;
  if (!zone.slots.length || zone.slots.includes(middle)) return middle;
  throw new ParameterError(`aim ${middle} is not a slot: the slots are ${zone.slots.join(", ")}`, "aim");
}

/** @param {Zone} zone @returns {number} how far from the zone's x a ball may start, m */
const spanOf = ({ jitter, reach }) => Math.max(jitter, reach);

/** @param {unknown} value @param {string} field @param {number} low @param {number} high */
function within(value, field, low, high) {
  if (typeof value === "number" && value >= low && value <= high) return value;
  throw new ParameterError(`${field} ${String(value)} is not a number from ${low} to ${high}`, field);
}

/** @param {unknown} value */
const isGiven = (value) => value !== null && value !== undefined;
