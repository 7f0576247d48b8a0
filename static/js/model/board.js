// A board as its JSON has it, and where a ball may start on it. Pure.

/**
 * Lengths in metres, y downwards; densities in kg/m², drag in 1/s, gravity in m/s².
 *
 * @typedef {{x: number, y: number}} Point
 * @typedef {{restitution: number, friction: number}} Material
 * @typedef {Material & {radius: number, density: number}} BallKind
 * @typedef {Point & {radius: number}} Peg
 * @typedef {{x1: number, y1: number, x2: number, y2: number}} Wall
 * @typedef {{y: number, edges: number[], multipliers: number[]}} Bins
 * @typedef {Point & {jitter: number, reach?: number, aim?: number, slots?: number[]}} DropZone where balls
 *   start: within `jitter` of x or of a player's aim, which is at most `aim` off or one of the slots
 *
 * @typedef {object} Board
 * @property {string} name
 * @property {number} width
 * @property {number} height
 * @property {number} gravity
 * @property {number} drag
 * @property {BallKind} ball
 * @property {Peg[]} pegs
 * @property {Material} peg_material
 * @property {Wall[]} walls
 * @property {Material} wall_material
 * @property {Bins} bins
 * @property {DropZone} drop
 */

/** @param {Pick<DropZone, "jitter" | "reach">} drop @returns {number} m from its x that a ball may start */
export const startSpan = ({ jitter, reach = 0 }) => Math.max(jitter, reach);

/**
 * @param {Pick<DropZone, "jitter" | "reach" | "aim">} drop
 * @returns {number} m from its x that a player may aim: what a seed then draws stays in the zone
 */
export const aimSpan = (drop) => Math.min(drop.aim ?? 0, startSpan(drop) - drop.jitter);

/**
 * The aim nearest to x that the board allows.
 * @param {{drop: Pick<DropZone, "x" | "jitter" | "reach" | "aim">}} board
 * @param {number[]} slots the only places to aim at, or none
 * @param {number} x metres
 * @returns {number} metres
 */
export function allowedAim(board, slots, x) {
  if (slots.length) {
    return slots.reduce((best, slot) => (Math.abs(slot - x) < Math.abs(best - x) ? slot : best));
  }
  const middle = board.drop.x;
  const span = aimSpan(board.drop);
  // Tenths of a millimetre keep links short; truncation keeps the value inside the range.
  const offset = Math.max(-span, Math.min(span, x - middle));
  return middle + Math.trunc(offset * 1e4) / 1e4;
}
