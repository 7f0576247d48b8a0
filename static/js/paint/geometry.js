// Maps a board to a canvas of a given width: metres to CSS pixels and back.

/** @import { Board } from "../model/board.js" */

// Boards of these widths, which the presets have, have margins, rails and bins of fixed sizes in metres. On
// narrower and wider boards they are in proportion, as in app/render/parts/view.py.
const USUAL_WIDTHS_M = [6, 8];
const SIDE_PAD_M = 0.08;
const HEADROOM_PX = 58; // for the hopper and a touch target above it
const MIN_BIN_PX = 34;
const BIN_M = 0.42;
// For bins with labels, which may be turned by a quarter.
const MIN_LABELLED_PX = 58;
const LABELLED_BIN_M = 1;

/**
 * @typedef {object} Geometry
 * @property {number} width CSS pixels
 * @property {number} height CSS pixels
 * @property {number} scale CSS pixels per metre
 * @property {number} metre CSS pixels per metre for the sizes that are given for boards of a usual width
 * @property {number} binTop the line at which a ball's centre enters a bin, CSS pixels
 * @property {number} binHeight CSS pixels
 * @property {number} dropY CSS pixels
 * @property {number} aimBottom a pointer above this line aims, CSS pixels
 * @property {(x: number) => number} px metres to pixels, across
 * @property {(y: number) => number} py metres to pixels, down
 * @property {(px: number) => number} x pixels to metres, across
 * @property {(px: number) => number} y pixels to metres, down
 */

/** @param {Board} board @returns {[number, number]} the left and right end of the board's parts, metres */
function endsOf(board) {
  const { edges } = board.bins;
  const walls = board.walls.flatMap((wall) => [wall.x1, wall.x2]);
  const { radius } = board.ball;
  const left = Math.min(edges[0], board.drop.x - radius, ...walls);
  return [left, Math.max(edges[edges.length - 1], board.drop.x + radius, ...walls)];
}

/** @param {Board} board @returns {number} the board's width in units of the nearest usual width */
function sizeOf(board) {
  const [left, right] = endsOf(board);
  const width = right - left;
  return width / Math.min(Math.max(width, USUAL_WIDTHS_M[0]), USUAL_WIDTHS_M[1]);
}

/** @param {Board} board @returns {{left: number, right: number}} metres */
export function sides(board) {
  const [left, right] = endsOf(board);
  const pad = SIDE_PAD_M * sizeOf(board);
  return { left: left - pad, right: right + pad };
}

/** @param {Board} board @returns {number} metres */
const binDepth = (board) => sizeOf(board) * (board.bins.labels ? LABELLED_BIN_M : BIN_M);

/** @param {Board} board @returns {number} width over height, without the headroom of fixed height */
export function ratioOf(board) {
  const { left, right } = sides(board);
  return (right - left) / (board.bins.y - board.drop.y + binDepth(board));
}

/**
 * @param {Board} board
 * @param {number} width CSS pixels
 * @returns {Geometry}
 */
export function layOut(board, width) {
  const { left, right } = sides(board);
  const scale = width / (right - left);
  const dropY = Math.max(HEADROOM_PX, board.ball.radius * scale + 44);
  /** @param {number} y */
  const py = (y) => dropY + (y - board.drop.y) * scale;
  const binTop = py(board.bins.y);
  const binHeight = Math.max(board.bins.labels ? MIN_LABELLED_PX : MIN_BIN_PX, binDepth(board) * scale);
  const firstPeg = board.pegs.reduce((least, peg) => Math.min(least, peg.y), board.bins.y);
  return {
    width,
    height: Math.round(binTop + binHeight + 6),
    scale,
    metre: scale * sizeOf(board),
    binTop,
    binHeight,
    dropY,
    aimBottom: Math.max(py(firstPeg) - board.ball.radius * scale, 64),
    px: (x) => (x - left) * scale,
    py,
    x: (px) => px / scale + left,
    y: (px) => (px - dropY) / scale + board.drop.y,
  };
}
