// Computes where a ball starts: at an explicit x, or where the seed draws it around the zone's x or an aim.

import { ParameterError } from "./errors.js";
import { seedOf, startX } from "./seed.js";

/** @import { WholeBoard } from "./input/values.js" */

/** @typedef {WholeBoard["drop"]} Zone */
/** @typedef {{x: number, explicit: boolean, aim: number | null}} Place x: the start, m */

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
