// Where a ball starts: where its seed says, about the board's middle or a player's aim, or at an x.

import { ParameterError } from "./errors.js";
import { seedOf, startX } from "./seed.js";

/** @import { WholeBoard } from "./input/values.js" */

/** @typedef {WholeBoard["drop"]} Zone */
/** @typedef {{x: number, explicit: boolean, aim: number | null}} Place x: the start, m */

/**
 * @param {Zone} zone
 * @param {bigint | null} seed
 * @param {{x?: unknown, aim?: unknown}} chosen by the player, m
 * @returns {Place} throws a ParameterError that names a bad value
 */
export function startOf(zone, seed, { x, aim }) {
  if (!isGiven(x)) {
    if (seed === null) throw new ParameterError("a drop needs a seed or an explicit x", "seed");
    const middle = isGiven(aim) ? aimOf(zone, aim) : null;
    return { x: startX(seed, middle ?? zone.x, zone.jitter), explicit: false, aim: middle };
  }
  if (isGiven(aim)) throw new ParameterError(`aim ${String(aim)} beside x ${String(x)}`, "aim");
  const span = spanOf(zone);
  const low = Math.min(zone.x - span, ...zone.slots);
  const high = Math.max(zone.x + span, ...zone.slots);
  return { x: within(x, "x", low, high), explicit: true, aim: null };
}

/**
 * @param {Zone} zone
 * @param {Iterable<string | bigint | number>} seeds
 * @param {number | null} aim m, of them all
 * @returns {Float64Array} where each starts, m
 */
export function startsOf(zone, seeds, aim) {
  const middle = isGiven(aim) ? aimOf(zone, aim) : zone.x;
  return Float64Array.from(seeds, (seed) => startX(seedOf(seed), middle, zone.jitter));
}

/** @param {Zone} zone @param {unknown} aim @returns {number} the middle of what a seed draws, m */
function aimOf(zone, aim) {
  const span = Math.min(zone.aim, spanOf(zone) - zone.jitter);
  const middle = within(aim, "aim", zone.x - span, zone.x + span) + 0;
  if (!zone.slots.length || zone.slots.includes(middle)) return middle;
  throw new ParameterError(`aim ${middle} is none of the slots ${zone.slots.join(", ")}`, "aim");
}

/** @param {Zone} zone @returns {number} m from its x that a ball may start */
const spanOf = ({ jitter, reach }) => Math.max(jitter, reach);

/** @param {unknown} value @param {string} field @param {number} low @param {number} high */
function within(value, field, low, high) {
  if (typeof value === "number" && value >= low && value <= high) return value;
  throw new ParameterError(`${field} ${String(value)} is not a number from ${low} to ${high}`, field);
}

/** @param {unknown} value */
const isGiven = (value) => value !== null && value !== undefined;
