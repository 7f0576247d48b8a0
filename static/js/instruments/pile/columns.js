// How a pile stands in the tray: its columns, how large its discs are, and how many balls each stands for. Pure.

/** @import { Board } from "../../model/board.js" */
/** @import { Geometry } from "../../paint/geometry.js" */

const SMALLEST = 2.5; // CSS pixels, a disc's radius, where its column leaves room for that
const LOOSE = 0.6; // of a column's area that discs take, however badly they lie
const MOST_DISCS = 240; // of a pile: moving all of them takes a part of a frame
const HEADROOM = 6; // radii that columns go on above the tray, where discs enter
const STEADY = { least: 1.5, most: 30 }; // m/s² by which discs fall, on whatever board: a pile must come to rest

/** @typedef {{largest: number, abreast: number}} Sizes of discs: CSS pixels, a radius; radii across a column */

/** @type {Sizes} below a board that is played at */
export const SMALL_DISCS = { largest: 6, abreast: 8 };

/** @type {Sizes} to be seen from the last row */
export const LARGE_DISCS = { largest: 24, abreast: 6 };

/**
 * @typedef {object} Plan
 * @property {number[]} edges of the columns, m, as the board has them
 * @property {number} height of the tray, m; its upper edge is y = 0
 * @property {number} radius of a disc, m
 * @property {number} entry y of a disc that enters, m
 * @property {number} gravity m/s²
 * @property {number[]} room discs that each column holds
 */

/**
 * @param {Pick<Board, "bins" | "gravity">} board
 * @param {Pick<Geometry, "scale">} geometry
 * @param {number} height of the tray, CSS pixels
 * @param {Sizes} [sizes]
 * @returns {Plan}
 */
export function planOf({ bins: { edges }, gravity }, { scale }, height, sizes = SMALL_DISCS) {
  const widths = edges.slice(1).map((edge, bin) => (edge - edges[bin]) * scale);
  const narrowest = Math.min(...widths);
  const wanted = Math.max(SMALLEST, Math.min(sizes.largest, narrowest / sizes.abreast));
  const size = Math.min(wanted, 0.45 * narrowest, 0.4 * height);
  const radius = size / scale;
  return {
    edges, height: height / scale, radius, entry: -2 * radius,
    gravity: Math.max(STEADY.least, Math.min(STEADY.most, gravity)),
    room: widths.map((width) => {
      const discs = (LOOSE * width * (height - size)) / (Math.PI * size * size);
      return Math.max(1, Math.floor(discs));
    }),
  };
}

/** What stands still: a floor, and a wall between any two columns. @param {Plan} plan */
export function placeOf({ edges, height, radius }) {
  const upright = (/** @type {number} */ x) => ({ x1: x, y1: -HEADROOM * radius, x2: x, y2: height });
  const floor = { x1: edges[0], y1: height, x2: edges[edges.length - 1], y2: height };
  // Dead walls: of a pair the livelier counts, so the discs decide.
  const material = { restitution: 0, friction: 0.3 };
  const walls = [...edges.map(upright), floor];
  return { pegs: [], walls, peg_material: material, wall_material: material, bins: null };
}

/**
 * How many balls a disc has to stand for: 1, 2, 5, 10, …
 * @param {number[]} counts balls by column
 * @param {Pick<Plan, "room">} plan
 * @param {number} [least]
 * @returns {number}
 */
export function shareFor(counts, { room }, least = 1) {
  for (let power = 1; ; power *= 10) {
    for (const share of [power, 2 * power, 5 * power]) {
      const discs = discsOf(counts, share);
      const all = discs.reduce((sum, count) => sum + count, 0);
      if (share >= least && all <= MOST_DISCS && discs.every((count, bin) => count <= room[bin])) return share;
    }
  }
}

/** @param {number[]} counts @param {number} share @returns {number[]} discs by column */
export function discsOf(counts, share) {
  return counts.map((count) => Math.floor(count / share));
}

/**
 * Where a disc enters of which it is not told, and how fast: side by side, as if from one tray's height.
 * @param {Plan} plan @param {number} bin @param {number} number of the disc in its column
 * @returns {Entry}
 */
export function usualEntry({ edges, height, gravity }, bin, number) {
  const part = (0.5 + number * 0.618034) % 1;
  return { x: edges[bin] + part * (edges[bin + 1] - edges[bin]), speed: Math.sqrt(2 * gravity * height) };
}

/** @typedef {{x: number, speed: number}} Entry m, and m/s downwards */

/** @param {Plan} plan @param {number} bin @param {Entry} entry @returns {Entry} one that the column has room for */
export function fittedEntry({ edges, radius, gravity }, bin, { x, speed }) {
  const [left, right] = [edges[bin] + 1.01 * radius, edges[bin + 1] - 1.01 * radius];
  return { x: Math.max(left, Math.min(right, x)), speed: Math.max(speed, Math.sqrt(2 * gravity * radius)) };
}
