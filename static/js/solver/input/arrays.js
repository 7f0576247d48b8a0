// Turns a board into the arrays that the kernels read: one of floats and one of words.
//
// Only + - * / and square root are used, in the engine's order, so that every bit is the same.

import { gridOf } from "./grid.js";
import { COLUMNS, DISTANCE, DISTANCE2, END_X, END_Y, X, Y } from "./surfaces.js";

/** @import { Material } from "../../model/board.js" */
/** @import { WholeBoard } from "./values.js" */

const HALF_WAY = 0.503;
const CELLS_PER_PITCH = 8;
const TRAVEL_PER_PITCH = 0.35;
const CELLS_PER_WALL = 500;

/**
 * @param {WholeBoard} board
 * @param {Float64Array} items its surfaces, from `Kernels.layOut`
 * @returns {{floats: Float64Array, words: Uint32Array}} laid out as in engine/artifact/entries.py
 */
export function arraysOf(board, items) {
  const { ball, gravity, drag, bins } = board;
  const count = items.length / COLUMNS;
  const longest = longestWall(items, ball.radius);
  const pitch = pitchOf(board, longest);
  const travel = TRAVEL_PER_PITCH * pitch;
  const fine = Math.min(CELLS_PER_PITCH / pitch, CELLS_PER_WALL / longest);
  const grid = gridOf(items, ball.radius, HALF_WAY * travel, fine);
  const pegs = combined(ball, board.peg_material);
  const walls = combined(ball, board.wall_material);
  const fall = gravity > 0 ? Math.sqrt((2 * travel) / gravity) : 1;
  const numbers = [grid.left, grid.top, grid.cellsPerMetre, travel, fall, gravity, drag, ball.radius,
    pegs.restitution, pegs.friction, walls.restitution, walls.friction, bins.y];
  const sizes = [count, grid.columns, grid.rows, board.pegs.length, grid.members.length,
    bins.edges.length];
  return {
    floats: joined(Float64Array, [numbers, items, centresOf(items, count), bins.edges]),
    words: joined(Uint32Array, [sizes, grid.starts, grid.members, grid.heads]),
  };
}

/**
 * @template {Float64Array | Uint32Array} T
 * @param {new (length: number) => T} kind
 * @param {ArrayLike<number>[]} parts
 * @returns {T}
 */
function joined(kind, parts) {
  const all = new kind(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}

/** @param {Material} a @param {Material} b */
function combined(a, b) {
  return {
    restitution: Math.max(a.restitution, b.restitution),
    friction: Math.sqrt(a.friction * b.friction),
  };
}

/**
 * The longest side of a straight wall's bounding box, m; without walls the ball's radius.
 * @param {Float64Array} items
 * @param {number} radius
 */
function longestWall(items, radius) {
  let longest = radius;
  for (let at = 0; at < items.length; at += COLUMNS) {
    const row = items.subarray(at);
    if (row[DISTANCE] > 0) continue;
    longest = Math.max(longest, Math.abs(row[END_X] - row[X]), Math.abs(row[END_Y] - row[Y]));
  }
  return longest;
}

/**
 * @param {WholeBoard} board
 * @param {number} longest wall, m
 * @returns {number} mean spacing of the pegs, m; with fewer than two an eighth of the longest wall
 */
function pitchOf({ pegs, ball }, longest) {
  if (pegs.length < 2) return Math.max(longest / 8, 4 * ball.radius);
  const [wide, high] = [span(pegs.map(({ x }) => x)), span(pegs.map(({ y }) => y))];
  const area = Math.max(wide, 1e-3 * high) * Math.max(high, 1e-3 * wide);
  return Math.max(Math.sqrt(area / pegs.length), ball.radius);
}

/** @param {number[]} values */
function span(values) {
  let [low, high] = [values[0], values[0]];
  for (const value of values) [low, high] = [Math.min(low, value), Math.max(high, value)];
  return high - low;
}

/** @param {Float64Array} items @param {number} count @returns {Float64Array} x, y and D^2 of each; D^2 is 0 for a line */
function centresOf(items, count) {
  const centres = new Float64Array(3 * (count + 1)); // the last row stays zero
  for (let i = 0; i < count; i += 1) {
    const row = items.subarray(COLUMNS * i);
    centres.set([row[X], row[Y], row[DISTANCE] === 0 ? 0 : row[DISTANCE2]], 3 * i);
  }
  return centres;
}
