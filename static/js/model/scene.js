// Everything that moves on a board at one moment, as it is to be drawn. Pure.

/** @import { Point } from "./board.js" */

/**
 * @typedef {object} Scene metres, radians
 * @property {SceneBall[]} balls
 * @property {Flash[]} flashes pegs just hit
 * @property {BinHit[]} hits bins just hit
 * @property {Point[][]} paths whole paths, as lines
 * @property {number | null} aim where a ball would start
 * @property {number | null} chosen id of the ball that is measured
 * @property {Streak[]} [streaks] ways of balls that landed as soon as they were dropped
 * @property {Parting | null} [fork] where another ball, started a hair aside, went another way
 *
 * @typedef {object} SceneBall
 * @property {number} x
 * @property {number} y
 * @property {number} angle
 * @property {boolean} mine
 * @property {string} [colour] #rrggbb; without one it has that of its kind, ours or another's
 * @property {Float64Array} trail x y x y …, newest first
 * @property {number} trailCount
 * @property {number} [id]
 * @property {string} [name] shown at the ball
 *
 * @typedef {{at: Point, path: Point[], hair: number, score: number}} Parting hair: how far aside, m; score: what
 *   the other's bin pays
 * @typedef {{points: Point[], age: number}} Streak age 0 … 1
 * @typedef {Point & {radius: number, age: number, strength: number}} Flash age and strength 0 … 1
 * @typedef {{bin: number, age: number, score: number, ticket?: boolean}} BinHit age 0 … 1; with a
 *   ticket of false what it paid is not written above it
 */

/** @returns {Scene} */
export function emptyScene() {
  return { balls: [], flashes: [], hits: [], paths: [], aim: null, chosen: null };
}
