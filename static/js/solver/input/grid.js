// The broad phase, a grid: each cell lists the surfaces that a ball in it may soon touch. The same as
// engine/exact/grid.py.

import { COLUMNS, DISTANCE, LENGTH, OWNER, TX, TY, X, Y } from "./surfaces.js";

const MAX_CELLS = 1 << 17;
const MAX_LISTED = 1 << 19; // cells in the boxes around all surfaces
const HEAD_BITS = 28;
const HEAD_MANY = 15; // the largest number of items that fits into a cell's head
const WIDER = 1 + 1e-9; // keeps cells that rounding would lose at the edge of an area

/**
 * @typedef {{left: number, top: number, cellsPerMetre: number, columns: number, rows: number,
 *   starts: Uint32Array, members: Uint32Array, heads: Uint32Array}} Grid
 * @typedef {{item: number, x: number, y: number, tx: number, ty: number, length: number,
 *   reach: number, low: [number, number], high: [number, number]}} Area all places within `reach` of a
 *   surface's point or line
 */

/**
 * @param {Float64Array} items rows of COLUMNS
 * @param {number} radius the ball's, m
 * @param {number} reach cells list what a ball can touch while its centre is within this distance of them, m
 * @param {number} fine cells per metre; fewer if the grid would become too large
 * @returns {Grid}
 */
export function gridOf(items, radius, reach, fine) {
  /** @type {Area[]} */
  const areas = [];
  for (let item = 0; item * COLUMNS < items.length; item += 1) {
    const row = items.subarray(item * COLUMNS);
    if (row[OWNER] === item) areas.push(areaOf(row, item, radius, reach));
  }
  if (areas.length === 0) return emptyGrid(fine);
  const [left, top] = [0, 1].map((axis) => least(areas, ({ low }) => low[axis]));
  const [width, height] = [0, 1].map((axis) =>
    -least(areas, ({ high }) => -high[axis]) - (axis ? top : left));
  let cellsPerMetre = fine;
  while ((width * cellsPerMetre + 1) * (height * cellsPerMetre + 1) > MAX_CELLS
      || listedIn(areas, left, top, cellsPerMetre) > MAX_LISTED) {
    cellsPerMetre *= 0.75;
  }
  const [columns, rows] = [width, height].map((side) => Math.trunc(side * cellsPerMetre) + 1);
  const found = areas.map((area) => cellsOf(area, left, top, cellsPerMetre, columns));
  return { left, top, cellsPerMetre, columns, rows, ...listed(areas, found, columns * rows) };
}

/** @param {number} cellsPerMetre @returns {Grid} */
function emptyGrid(cellsPerMetre) {
  const [starts, members, heads] = [2, 0, 1].map((length) => new Uint32Array(length));
  return { left: 0, top: 0, cellsPerMetre, columns: 0, rows: 0, starts, members, heads };
}

/** @param {Area[]} areas @param {(area: Area) => number} value */
function least(areas, value) {
  return areas.reduce((best, area) => Math.min(best, value(area)), Infinity);
}

/**
 * @param {Float64Array} row
 * @param {number} item
 * @param {number} radius
 * @param {number} near
 * @returns {Area}
 */
function areaOf(row, item, radius, near) {
  const round = row[DISTANCE] > 0;
  const [x, y] = [row[X], row[Y]];
  const [tx, ty, length] = round ? [1, 0, 0] : [row[TX], row[TY], row[LENGTH]];
  const reach = WIDER * ((round ? row[DISTANCE] : radius) + near);
  const [endX, endY] = [x + length * tx, y + length * ty];
  return {
    item, x, y, tx, ty, length, reach,
    low: [Math.min(x, endX) - reach, Math.min(y, endY) - reach],
    high: [Math.max(x, endX) + reach, Math.max(y, endY) + reach],
  };
}

/**
 * First and last column, first and last row of an area's bounding box.
 * @param {Area} area
 * @param {number} left
 * @param {number} top
 * @param {number} cellsPerMetre
 */
function boxOf({ low, high }, left, top, cellsPerMetre) {
  return [low[0] - left, high[0] - left, low[1] - top, high[1] - top]
    .map((side) => Math.trunc(side * cellsPerMetre));
}

/** @param {Area[]} areas @param {number} left @param {number} top @param {number} cellsPerMetre */
function listedIn(areas, left, top, cellsPerMetre) {
  return areas.reduce((count, area) => {
    const [firstColumn, lastColumn, firstRow, lastRow] = boxOf(area, left, top, cellsPerMetre);
    return count + (lastColumn - firstColumn + 1) * (lastRow - firstRow + 1);
  }, 0);
}

/**
 * Numbers of the cells that an area touches; along a slanted line also some near it.
 * @param {Area} area
 * @param {number} left
 * @param {number} top
 * @param {number} cellsPerMetre
 * @param {number} columns
 */
function cellsOf(area, left, top, cellsPerMetre, columns) {
  const size = 1 / cellsPerMetre;
  const [firstColumn, lastColumn, firstRow, lastRow] = boxOf(area, left, top, cellsPerMetre);
  const cells = [];
  for (let ix = firstColumn; ix <= lastColumn; ix += 1) {
    for (let iy = firstRow; iy <= lastRow; iy += 1) {
      if (touches(area, left + ix * size - area.x, top + iy * size - area.y, size)) {
        cells.push(ix + columns * iy);
      }
    }
  }
  return cells;
}

/**
 * @param {Area} area
 * @param {number} x of the cell's corner, relative to the area's first point
 * @param {number} y
 * @param {number} size of the cell
 */
function touches({ tx, ty, length, reach }, x, y, size) {
  if (length === 0) {
    const dx = Math.max(Math.max(x, -x - size), 0);
    const dy = Math.max(Math.max(y, -y - size), 0);
    return dx * dx + dy * dy <= reach * reach;
  }
  // Compares the line's distance from the cell's centre with reach plus half the cell's diagonal.
  const [cx, cy] = [x + 0.5 * size, y + 0.5 * size];
  const along = Math.min(Math.max(cx * tx + cy * ty, 0), length);
  const [dx, dy] = [cx - along * tx, cy - along * ty];
  const far = reach + 0.7072 * size;
  return dx * dx + dy * dy <= far * far;
}

/**
 * The items of each cell, in order. After the last cell comes an empty one for all places outside.
 * @param {Area[]} areas in the order of their items
 * @param {number[][]} found the cells of each area
 * @param {number} count of cells
 */
function listed(areas, found, count) {
  const starts = new Uint32Array(count + 2);
  for (const cells of found) for (const cell of cells) starts[cell + 1] += 1;
  for (let cell = 0; cell <= count; cell += 1) starts[cell + 1] += starts[cell];
  const next = starts.slice();
  const members = new Uint32Array(starts[count + 1]);
  areas.forEach(({ item }, i) => {
    for (const cell of found[i]) {
      members[next[cell]] = item;
      next[cell] += 1;
    }
  });
  const heads = new Uint32Array(count + 1);
  for (let cell = 0; cell <= count; cell += 1) {
    const many = Math.min(starts[cell + 1] - starts[cell], HEAD_MANY);
    if (many > 0) heads[cell] = members[starts[cell]] | (many << HEAD_BITS);
  }
  return { starts, members, heads };
}
