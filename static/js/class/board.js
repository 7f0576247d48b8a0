// The class's Galton boards, as a board's JSON form. Pure.
//
// Real balls remember: a ball that went right tends to go right again, which makes the bins wider than the binomial
// law says. Here the gap between two pegs is only 3 % of their distance wider than the ball. A ball rattles in it until
// its next way no longer depends on the last one. `tools/class-leans.js` measures how well that works.
//
// Each row is shifted to the left, by a part of the distance between pegs: the lean. The ball then meets the next peg
// on the right of its middle, and goes right more often. `leans.json` has the probability for each lean.

import record from "./leans.json" with { type: "json" };

/** @import { Board } from "../model/board.js" */

/**
 * @typedef {object} Setting of a board
 * @property {number} rows 5 … 30
 * @property {number} p the probability that a ball goes right at a row, 0.2 … 0.8, with the usual restitution
 * @property {number} restitution 0.5 … 0.9
 * @property {number} gravity m/s²
 */

export const ROWS = { least: 5, most: 30 };
export const P = { least: 0.2, most: 0.8 };
export const RESTITUTION = 0.8; // the only one for which p is calibrated

const SPACING = 0.03; // m, between the middles of two pegs
const PITCH = 0.93 * SPACING; // between two rows
const PEG = 0.14 * SPACING;
const BALL = 0.3445 * SPACING;
const JITTER = 0.1 * SPACING; // of the start
const WALL = 0.25; // from the outermost pegs to a side, in spacings
const DENSITY = 1; // kg/m²: the path does not depend on it

/** @param {number} p @param {number[][]} leans with the p of each @returns {number} spacings per row; negative for p below 1/2 */
export function leanOf(p, leans = record.leans) {
  const far = 0.5 + Math.abs(p - 0.5);
  const next = Math.max(1, leans.findIndex(([, right]) => right >= far));
  const [[from, low], [to, high]] = [leans[next - 1], leans[next]];
  return Math.sign(p - 0.5) * (from + ((far - low) / (high - low)) * (to - from));
}

/** @param {Setting} setting @returns {Board} row i has i + 3 pegs; bin k has the balls that went right k times */
export function boardOf({ rows, p, restitution, gravity }) {
  return leaning(rows, leanOf(p), restitution, gravity);
}

/**
 * @param {number} rows @param {number} lean in spacings per row @param {number} restitution @param {number} gravity m/s²
 * @returns {Board}
 */
export function leaning(rows, lean, restitution, gravity) {
  /** @param {number} row @param {number} place in spacings from the row's middle */
  const across = (row, place) => SPACING * (place - lean * row);
  const line = PITCH * (rows - 1) + BALL; // there a ball can no longer change its bin
  /** @param {number} row @param {number} side -1 or 1 */
  const wall = (row, side) => across(row, side * (1 + WALL + row / 2));
  const below = rows - 0.4; // where the sides end, in rows
  const walls = [-1, 1].flatMap((side) => [
    { x1: wall(-1, side), y1: -PITCH, x2: wall(below, side), y2: PITCH * below },
    { x1: wall(-1, side) + side * SPACING, y1: -2 * PITCH, x2: wall(-1, side), y2: -PITCH },
  ]);
  const inner = Array.from({ length: rows }, (_, j) => across(rows - 1, j - (rows - 1) / 2));
  const surface = { restitution, friction: 0 };
  return {
    name: "class", width: SPACING * (rows + 4), height: line + SPACING, gravity, drag: 0,
    ball: { radius: BALL, density: DENSITY, ...surface },
    pegs: Array.from({ length: rows }, (_, row) => row).flatMap((row) =>
      Array.from({ length: row + 3 }, (_, j) => ({ x: across(row, j - 1 - row / 2), y: PITCH * row, radius: PEG }))),
    peg_material: surface,
    walls,
    wall_material: surface,
    bins: {
      y: line, multipliers: new Array(rows + 1).fill(1),
      edges: [wall(line / PITCH, -1), ...inner, wall(line / PITCH, 1)],
    },
    // A row above, the ball would leave the middle of a gap.
    drop: { x: SPACING * lean, y: -PITCH, jitter: JITTER },
  };
}
