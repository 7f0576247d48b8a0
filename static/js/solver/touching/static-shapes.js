// The pegs and walls of an arena, for the kernels.

import { floats } from "../machine.js";

/** @import { Machine, Value } from "../machine.js" */
/** @import { Place } from "./scenes.js" */

/** @typedef {[number, number, number, number]} Corners x_min, x_max, y_min, y_max in m */

/** @param {Place} place @returns {Corners} of the box around all parts */
export function extentOf({ pegs, walls, bins }) {
  const xs = walls.flatMap(({ x1, x2 }) => [x1, x2]);
  const ys = walls.flatMap(({ y1, y2 }) => [y1, y2]);
  for (const { x, y, radius } of pegs) {
    xs.push(x - radius, x + radius);
    ys.push(y - radius, y + radius);
  }
  if (bins) {
    xs.push(bins.edges[0], /** @type {number} */ (bins.edges.at(-1)));
    ys.push(bins.y);
  }
  return xs.length ? [least(xs), most(xs), least(ys), most(ys)] : [0, 0, 0, 0];
}

/**
 * The pegs and walls as the kernels take them, with the grid that finds them.
 * @param {Machine} machine @param {Place} place
 * @returns {Value[]} arguments for the kernels
 */
export function staticShapes(machine, place) {
  const { pegs, walls, peg_material: ofPegs, wall_material: ofWalls, bins } = place;
  return machine.run("plinko.engine.multibody.solver.static_grid.lay_out_shapes", [
    floats(pegs.flatMap(({ x, y, radius }) => [x, y, radius]), pegs.length, 3),
    floats(walls.flatMap(({ x1, y1, x2, y2 }) => [x1, y1, x2, y2]), walls.length, 4),
    ofPegs.restitution, ofPegs.friction, ofWalls.restitution, ofWalls.friction, ...extentOf(place),
    bins?.y ?? Infinity,
  ]);
}

/** @param {number[]} values */
function least(values) {
  return values.reduce((one, other) => Math.min(one, other));
}

/** @param {number[]} values */
function most(values) {
  return values.reduce((one, other) => Math.max(one, other));
}
