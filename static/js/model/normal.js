// The direction in which a surface pushes a ball that touches it. Pure.

import { PEG, WALL } from "./motion/kinds.js";

/** @import { Board, Point, Wall } from "./board.js" */

/**
 * Unit normal from the peg or wall that was touched to the ball. In contacts, wall w has the index -1 - w.
 * @param {Pick<Board, "pegs" | "walls">} board
 * @param {number} kind of event
 * @param {number} index
 * @param {Point} centre of the ball, metres
 * @returns {Point}
 */
export function normalAt(board, kind, index, { x, y }) {
  const isWall = kind === WALL || (kind !== PEG && index < 0);
  const wall = kind === WALL ? index : -1 - index;
  const from = isWall ? nearestOn(board.walls[wall], x, y) : board.pegs[index];
  const dx = x - from.x;
  const dy = y - from.y;
  const length = Math.hypot(dx, dy);
  return { x: dx / length, y: dy / length };
}

/**
 * @param {Wall} wall
 * @param {number} x
 * @param {number} y
 * @returns {Point} the point of a wall nearest to (x, y), metres
 */
function nearestOn({ x1, y1, x2, y2 }, x, y) {
  const dx = x2 - x1;
  const dy = y2 - y1;
  const along = ((x - x1) * dx + (y - y1) * dy) / (dx * dx + dy * dy);
  const s = Math.min(1, Math.max(0, along));
  return { x: x1 + s * dx, y: y1 + s * dy };
}
