// Everything that is drawn over a board at one moment. Pure.

/** @import { Point } from "./board.js" */

/**
 * @typedef {object} Scene metres, radians
 * @property {SceneBall[]} balls
 * @property {Flash[]} flashes glowing pegs, hit a moment ago
 * @property {BinHit[]} hits bins hit a moment ago
 * @property {Point[][]} paths whole paths
 * @property {number | null} aim x at which the next ball would start
 * @property {Streak[]} [streaks] paths of balls shown at instant pace
 * @property {Parting | null} [fork] the path of a second ball, which started a tiny distance away and
 *   took another way
 *
 * @typedef {object} SceneBall
 * @property {number} x
 * @property {number} y
 * @property {number} angle
 * @property {boolean} mine
 * @property {string} [colour] #rrggbb; by default the colour for this player's or others' balls
 * @property {Point[]} trail newest first
 * @property {number} [id]
 * @property {string} [name] shown at the ball
 *
 * @typedef {{at: Point, path: Point[], hair: number, score: number}} Parting at: where the
 *   paths part; hair: distance of the starts, m; score: of the second ball
 * @typedef {{points: Point[], age: number}} Streak age 0 … 1
 * @typedef {Point & {radius: number, age: number, strength: number}} Flash age and strength 0 … 1
 * @typedef {{bin: number, age: number, score: number, ticket?: boolean}} BinHit age 0 … 1; the score is
 *   written above the bin unless ticket is false
 */

/** @returns {Scene} */
export function emptyScene() {
  return { balls: [], flashes: [], hits: [], paths: [], aim: null };
}
