// Plans a pile in the tray: its columns, the size of its discs, and how many balls each disc represents. In a tray wider
// than its board the columns fan out from the bins to the tray's sides. Pure.

/** @import { Board } from "../../model/board.js" */
/** @import { Geometry } from "../../paint/geometry.js" */

const SMALLEST = 2.5; // smallest radius of a disc, CSS pixels; less only in narrower columns
const LOOSE = 0.6; // fraction of a column's area that discs fill even if they lie badly
const MOST_DISCS = 240; // of a pile; moving more would take too much of a frame
const HEADROOM = 6; // radii that columns extend above the tray, where discs enter
const WIDEST = 1.6; // how many times as wide as a bin a column is at most, at the floor
const SIDE = 8; // CSS pixels free at each end of a wide tray
const STEADY = { least: 1.5, most: 30 }; // m/s²: limits of the pile's gravity, so that it comes to rest

/** @typedef {{largest: number, abreast: number}} Sizes largest: radius of a disc, CSS pixels; abreast: width of
 *   the narrowest column, in radii */

/** @type {Sizes} for the tray of a game page */
export const SMALL_DISCS = { largest: 6, abreast: 8 };

/** @type {Sizes} for the stage, visible from the last row */
export const LARGE_DISCS = { largest: 24, abreast: 6 };

/**
 * @typedef {object} Plan
 * @property {number[]} edges of the columns at the top, m, the same as the bins'
 * @property {number[]} floors the same at the floor, m
 * @property {number} height of the tray, m; its upper edge is y = 0
 * @property {number} radius of a disc, m
 * @property {number} entry y at which discs enter, m
 * @property {number} gravity m/s²
 * @property {number[]} room how many discs fit into each column
 */

/** @typedef {Pick<Geometry, "width" | "scale" | "px"> & {spread: number}} TrayGeometry spread: how many times as wide as
 *   at the top the columns are at the floor */

/**
 * @param {Pick<Board, "bins">} board
 * @param {Geometry} geometry of the board above
 * @param {number} width of the tray, whose middle is the board's, CSS pixels
 * @returns {TrayGeometry}
 */
export function trayGeometry({ bins: { edges } }, { width: over, scale, px }, width) {
  const bins = (edges[edges.length - 1] - edges[0]) * scale;
  const spread = Math.max(1, Math.min(WIDEST, (width - 2 * SIDE) / bins));
  return { width, scale, spread: width > over ? spread : 1, px: (x) => px(x) + (width - over) / 2 };
}

/** @param {number[]} edges @param {number} spread @returns {number[]} the same edges, spread out from their middle */
export function spreadOut(edges, spread) {
  const middle = (edges[0] + edges[edges.length - 1]) / 2;
  return edges.map((edge) => (spread === 1 ? edge : middle + spread * (edge - middle)));
}

/**
 * @param {Pick<Board, "bins" | "gravity">} board
 * @param {Pick<TrayGeometry, "scale" | "spread">} geometry
 * @param {number} height of the tray, CSS pixels
 * @param {Sizes} [sizes]
 * @returns {Plan}
 */
export function planOf({ bins: { edges }, gravity }, { scale, spread }, height, sizes = SMALL_DISCS) {
  const widths = edges.slice(1).map((edge, bin) => (edge - edges[bin]) * scale);
  const narrowest = Math.min(...widths);
  const wanted = Math.max(SMALLEST, Math.min(sizes.largest, narrowest / sizes.abreast));
  const size = Math.min(wanted, 0.45 * narrowest, 0.4 * height);
  const radius = size / scale;
  return {
    edges, floors: spreadOut(edges, spread), height: height / scale, radius, entry: -2 * radius,
    gravity: Math.max(STEADY.least, Math.min(STEADY.most, gravity)),
    room: widths.map((width) => {
      const discs = (LOOSE * width * ((1 + spread) / 2) * (height - size)) / (Math.PI * size * size);
      return Math.max(1, Math.floor(discs));
    }),
  };
}

/** The fixed parts: a floor, and a wall between any two columns. @param {Plan} plan */
export function placeOf({ edges, floors, height, radius }) {
  const top = -HEADROOM * radius;
  const between = edges.flatMap((x, i) => {
    const low = floors[i];
    if (low === x) return [{ x1: x, y1: top, x2: x, y2: height }];
    return [{ x1: x, y1: top, x2: x, y2: 0 }, { x1: x, y1: 0, x2: low, y2: height }];
  });
  const floor = { x1: floors[0], y1: height, x2: floors[floors.length - 1], y2: height };
  // An impact uses the larger restitution of the two bodies. With 0 for walls, the discs decide.
  const material = { restitution: 0, friction: 0.3 };
  const walls = [...between, floor];
  return { pegs: [], walls, peg_material: material, wall_material: material, bins: null };
}

/**
 * How many balls a disc must represent so that the pile fits: 1, 2, 5, 10, …
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
 * The default place and speed of an entering disc: spread over the column, as fast as after a fall of the
 * tray's height.
 * @param {Plan} plan @param {number} bin @param {number} number of the disc in its column
 * @returns {Entry}
 */
export function usualEntry({ edges, height, gravity }, bin, number) {
  const part = (0.5 + number * 0.618034) % 1;
  return { x: edges[bin] + part * (edges[bin + 1] - edges[bin]), speed: Math.sqrt(2 * gravity * height) };
}

/** @typedef {{x: number, speed: number}} Entry m, and m/s downwards */

/** @param {Plan} plan @param {number} bin @param {Entry} entry @returns {Entry} moved into the column, with a minimum speed */
export function fittedEntry({ edges, radius, gravity }, bin, { x, speed }) {
  const [left, right] = [edges[bin] + 1.01 * radius, edges[bin + 1] - 1.01 * radius];
  return { x: Math.max(left, Math.min(right, x)), speed: Math.max(speed, Math.sqrt(2 * gravity * radius)) };
}
