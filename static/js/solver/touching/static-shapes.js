// Pegs and walls as the arrays that the kernels take: their rows, and the grid that finds them.
// engine/multibody/static_geometry.py makes the same, operation by operation.

/** @import { Grid, Value } from "./machine.js" */
/** @import { Place } from "./scenes.js" */

const COLUMNS = 8; // x1, y1, tx, ty, length, radius, restitution, friction
const CELLS = 64; // at most, along the longer side of the grid

/** @typedef {[number, number, number, number]} Corners x_min, x_max, y_min, y_max in m */

/**
 * @typedef {object} StaticShapes
 * @property {Value[]} values arguments for the kernels
 * @property {number} pegs
 */

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

/** @param {Place} place @returns {StaticShapes} */
export function staticShapes(place) {
  const items = itemsOf(place);
  const [x0, x1, y0, y1] = extentOf(place);
  const side = Math.max(x1 - x0, y1 - y0, 1e-9);
  const count = Math.min(CELLS, Math.max(1, Math.floor(Math.sqrt((32 * items.length) / COLUMNS))));
  const scale = count / side;
  const columns = Math.trunc((x1 - x0) * scale) + 1;
  const rows = Math.trunc((y1 - y0) * scale) + 1;
  const { starts, members } = gridOf(items, x0, y0, scale, columns, rows);
  return {
    values: [
      { values: items, shape: [items.length / COLUMNS, COLUMNS] }, BigInt(place.pegs.length),
      x0, y0, scale, BigInt(columns), BigInt(rows), starts, members, place.bins?.y ?? Infinity,
    ],
    pegs: place.pegs.length,
  };
}

/** @param {Place} place */
function itemsOf({ pegs, walls, peg_material: ofPegs, wall_material: ofWalls }) {
  const rows = pegs.map(({ x, y, radius }) =>
    [x, y, 1, 0, 0, radius, ofPegs.restitution, ofPegs.friction]);
  for (const { x1, y1, x2, y2 } of walls) {
    const [dx, dy] = [x2 - x1, y2 - y1];
    const length = Math.sqrt(dx * dx + dy * dy);
    rows.push([x1, y1, dx / length, dy / length, length, 0, ofWalls.restitution, ofWalls.friction]);
  }
  return Float64Array.from(rows.flat());
}

/**
 * Lists the items that pass through each cell.
 * @param {Float64Array} items @param {number} x0 @param {number} y0 @param {number} scale
 * @param {number} columns @param {number} rows
 * @returns {{starts: Grid, members: Grid}} members: ascending in each cell
 */
function gridOf(items, x0, y0, scale, columns, rows) {
  /** @type {number[][]} */
  const lists = Array.from({ length: columns * rows }, () => []);
  const size = 1 / scale;
  for (let item = 0; item < items.length / COLUMNS; item += 1) {
    const [x, y, tx, ty, length, thickness] = items.subarray(COLUMNS * item, COLUMNS * item + 6);
    const [endX, endY] = [x + length * tx, y + length * ty];
    const low = Math.max(Math.trunc((Math.min(x, endX) - thickness - x0) * scale) - 1, 0);
    const high = Math.min(Math.trunc((Math.max(x, endX) + thickness - x0) * scale) + 1, columns - 1);
    const top = Math.max(Math.trunc((Math.min(y, endY) - thickness - y0) * scale) - 1, 0);
    const bottom = Math.min(Math.trunc((Math.max(y, endY) + thickness - y0) * scale) + 1, rows - 1);
    const near = thickness + 0.7072 * size * (1 + 1e-6);
    for (let row = top; row <= bottom; row += 1) {
      for (let column = low; column <= high; column += 1) {
        let dx = x0 + (column + 0.5) * size - x;
        let dy = y0 + (row + 0.5) * size - y;
        const along = Math.min(Math.max(dx * tx + dy * ty, 0), length);
        dx -= along * tx;
        dy -= along * ty;
        if (dx * dx + dy * dy <= near * near) lists[row * columns + column].push(item);
      }
    }
  }
  const starts = new Int32Array(lists.length + 1);
  lists.forEach((members, cell) => {
    starts[cell + 1] = starts[cell] + members.length;
  });
  const members = Int32Array.from(lists.flat());
  return {
    starts: { values: starts, shape: [starts.length] },
    members: { values: members, shape: [members.length] },
  };
}

/** @param {number[]} values */
function least(values) {
  return values.reduce((one, other) => Math.min(one, other));
}

/** @param {number[]} values */
function most(values) {
  return values.reduce((one, other) => Math.max(one, other));
}
