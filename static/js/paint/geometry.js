// Where a board lies on a canvas of a given width: metres to CSS pixels and back.

const SIDE_PAD_M = 0.08;
const HEADROOM_PX = 58; // the hopper, and a touch target above it
const MIN_BIN_PX = 34;
const BIN_M = 0.42;

/**
 * @typedef {object} Geometry
 * @property {number} width CSS pixels
 * @property {number} height CSS pixels
 * @property {number} scale CSS pixels per metre
 * @property {number} binTop where the balls' centres cross into a bin, CSS pixels
 * @property {number} binHeight CSS pixels
 * @property {number} dropY CSS pixels
 * @property {number} aimBottom pointers above it aim and drop, CSS pixels
 * @property {(x: number) => number} px metres to pixels, across
 * @property {(y: number) => number} py metres to pixels, down
 * @property {(px: number) => number} x pixels to metres, across
 * @property {(px: number) => number} y pixels to metres, down
 */

/** @param {any} board the JSON form @returns {{left: number, right: number}} metres */
export function sides(board) {
  const { edges } = board.bins;
  const walls = board.walls.flatMap((wall) => [wall.x1, wall.x2]);
  const { radius } = board.ball;
  return {
    left: Math.min(edges[0], board.drop.x - radius, ...walls) - SIDE_PAD_M,
    right: Math.max(edges[edges.length - 1], board.drop.x + radius, ...walls) + SIDE_PAD_M,
  };
}

/** @param {any} board @returns {number} width over height of the part that scales */
function ratio(board) {
  const { left, right } = sides(board);
  return (right - left) / (board.bins.y - board.drop.y + BIN_M);
}

/** Tells the style sheet the board's shape, so that cabinet and desk fit the window. */
export function announceShape(board) {
  const { dataset, style } = document.documentElement;
  style.setProperty("--board-ratio", ratio(board).toFixed(4));
  dataset.shape = ratio(board) < 1 ? "tall" : "wide";
}

/**
 * @param {any} board
 * @param {number} width CSS pixels
 * @returns {Geometry}
 */
export function layOut(board, width) {
  const { left, right } = sides(board);
  const scale = width / (right - left);
  const dropY = Math.max(HEADROOM_PX, board.ball.radius * scale + 44);
  const py = (y) => dropY + (y - board.drop.y) * scale;
  const binTop = py(board.bins.y);
  const binHeight = Math.max(MIN_BIN_PX, BIN_M * scale);
  const firstPeg = board.pegs.reduce((least, peg) => Math.min(least, peg.y), board.bins.y);
  return {
    width,
    height: Math.round(binTop + binHeight + 6),
    scale,
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

/** How far from its x a ball may start, m, slots aside. @param {any} drop of a board */
export const startSpan = ({ jitter, reach = 0 }) => Math.max(jitter, reach);

/**
 * The start nearest to x that the board allows.
 * @param {any} board
 * @param {number[]} slots explicit places, or none
 * @param {number} x metres
 */
export function allowedStart(board, slots, x) {
  if (slots.length) {
    return slots.reduce((best, slot) => (Math.abs(slot - x) < Math.abs(best - x) ? slot : best));
  }
  const middle = board.drop.x;
  const span = startSpan(board.drop);
  // Tenths of a millimetre keep links short; truncation keeps the value inside the range.
  const offset = Math.max(-span, Math.min(span, x - middle));
  return middle + Math.trunc(offset * 1e4) / 1e4;
}
