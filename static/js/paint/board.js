// Paints what never moves: plate, rails, pegs and bins. Called only when size or theme change.

import { labelOf, sidesOf, startSpan } from "../model/board.js";
import { disc, strokeLine } from "../util/canvas.js";
import { multiplier } from "../util/format.js";
import { GROUNDS, paintEnamel, SURROUNDINGS } from "./ground.js";
import { paintPeg } from "./peg.js";
import { coloursOf, paintPrizes } from "./prizes.js";

/** @import { Board, Wall } from "../model/board.js" */
/** @import { Geometry } from "./geometry.js" */
/** @import { Look } from "./theme.js" */

export const LABEL_FONT = '"DIN Alternate", Bahnschrift, "Liberation Sans Narrow", "Arial Narrow", sans-serif';
const FILLED = 0.9; // of a pocket's width, by the widest number
const LEGIBLE = 8.5; // smallest size of a number, CSS pixels

/** @typedef {{around: boolean, plate: boolean}} Grounds which backdrops are painted: around the board, and on its plate */

/** @type {Grounds} */
export const ALL_GROUNDS = { around: true, plate: true };

/** @typedef {{ctx: CanvasRenderingContext2D, geometry: Geometry, board: Board, look: Look}} Sheet in CSS pixels */

/** @param {Sheet} sheet @param {number[]} slots @param {Grounds} [grounds] */
export function paintBoard(sheet, slots, grounds) {
  paintField(sheet, slots, grounds);
  paintFront(sheet);
}

/** Paints what lies behind bins and rails. @param {Sheet} sheet @param {number[]} slots @param {Grounds} [grounds] */
export function paintField(sheet, slots, grounds = ALL_GROUNDS) {
  const { ctx, geometry: { width, height } } = sheet;
  ctx.clearRect(0, 0, width, height);
  if (grounds.around) paintSurroundings(sheet);
  if (grounds.plate) paintPlate(sheet);
  paintHopper(sheet, slots);
  paintPegs(sheet);
}

/** @param {Sheet} sheet */
export function paintFront(sheet) {
  paintBins(sheet);
  paintRails(sheet);
}

/** @param {Sheet} sheet */
function paintSurroundings(sheet) {
  const { ctx, geometry: { width, height }, look: { palette: { shoulder }, ground } } = sheet;
  ctx.fillStyle = shoulder;
  ctx.fillRect(0, 0, width, height);
  SURROUNDINGS[ground](ctx, placeOn(sheet));
  if (ground === "rays") return;
  // The sides fade into the page's colour next to them.
  const fade = ctx.createLinearGradient(0, 0, width, 0);
  for (const [at, alpha] of [[0, "ff"], [0.07, "00"], [0.93, "00"], [1, "ff"]]) {
    fade.addColorStop(Number(at), `${shoulder}${alpha}`);
  }
  ctx.fillStyle = fade;
  ctx.fillRect(0, 0, width, height);
}

/** @param {Sheet} sheet */
function placeOn({ geometry: { px, dropY, width, height }, board, look: { palette: colours, shapes, grounds } }) {
  return { x: px(board.drop.x), y: dropY, width, height, colours, rays: shapes.rays, grounds };
}

/** @param {Sheet} sheet */
function paintPlate(sheet) {
  const { ctx, geometry: { width, height }, look: { palette: colours, ground } } = sheet;
  ctx.save();
  clipToField(sheet);
  paintEnamel(ctx, colours, width, height);
  GROUNDS[ground](ctx, placeOn(sheet));
  ctx.restore();
}

/** @typedef {{x: number, y: number, width: number, height: number}} Box */

/** Clips to the part between the left and the right side walls, if the board has both. @param {Sheet} sheet */
function clipToField({ ctx, geometry: { px, py, width, height }, board }) {
  const sides = sidesOf(board);
  const left = chain(board.walls.filter((_, number) => sides[number] < 0));
  const right = chain(board.walls.filter((_, number) => sides[number] > 0));
  ctx.beginPath();
  if (left.length && right.length) {
    const outline = [...left, ...right.reverse()].map(({ x, y }) => ({ x: px(x), y: py(y) }));
    ctx.moveTo(outline[0].x, 0);
    for (const { x, y } of outline.slice(0, left.length)) ctx.lineTo(x, y);
    ctx.lineTo(outline[left.length - 1].x, height);
    ctx.lineTo(outline[left.length].x, height);
    for (const { x, y } of outline.slice(left.length)) ctx.lineTo(x, y);
    ctx.lineTo(outline[outline.length - 1].x, 0);
  } else {
    ctx.rect(0, 0, width, height);
  }
  ctx.clip();
}

/** The ends of walls from top to bottom. @param {Wall[]} walls */
function chain(walls) {
  const ends = walls.flatMap(({ x1, y1, x2, y2 }) => [{ x: x1, y: y1 }, { x: x2, y: y2 }]);
  return ends.sort((one, two) => one.y - two.y);
}

/**
 * Paints the slide along which a ball may start, or the numbered slots.
 * @param {Sheet} sheet @param {number[]} slots
 */
function paintHopper({ ctx, geometry: { px, dropY, scale }, board, look: { palette: colours } }, slots) {
  const radius = Math.max(board.ball.radius * scale, 5);
  ctx.lineCap = "round";
  if (slots.length) {
    ctx.font = `700 ${Math.round(Math.max(12, Math.min(20, 0.2 * scale)))}px ${LABEL_FONT}`;
    ctx.textAlign = "center";
    ctx.textBaseline = "middle";
    slots.forEach((slot, index) => {
      ctx.fillStyle = colours.railShade;
      disc(ctx, px(slot), dropY, radius + 3);
      ctx.fillStyle = colours.rail;
      ctx.fillText(String(index + 1), px(slot), dropY - radius - 16);
    });
    return;
  }
  const { x } = board.drop;
  const span = startSpan(board.drop);
  ctx.strokeStyle = colours.railShade;
  ctx.lineWidth = 2 * radius + 6;
  strokeLine(ctx, px(x - span), dropY, px(x + span), dropY);
}

/** @param {Sheet} sheet */
function paintPegs({ ctx, geometry: { px, py, scale }, board, look: { palette: colours, shapes: { peg: shape } } }) {
  const { across, down, alpha } = shape.shadow;
  ctx.globalAlpha = alpha;
  ctx.fillStyle = colours.shadow;
  for (const peg of board.pegs) {
    const r = peg.radius * scale;
    disc(ctx, px(peg.x) + across * r, py(peg.y) + down * r, r);
  }
  ctx.globalAlpha = 1;
  for (const peg of board.pegs) {
    paintPeg(ctx, { x: px(peg.x), y: py(peg.y), r: peg.radius * scale }, colours, shape);
  }
}

/** @param {Sheet} sheet */
function paintRails({ ctx, geometry: { px, py, metre }, board, look: { palette: colours, shapes } }) {
  const { metres, least, shade } = shapes.rail;
  const width = Math.max(least, metres * metre);
  ctx.lineCap = "round";
  ctx.lineWidth = width;
  const sides = sidesOf(board);
  // All shades come before the rails, so that none covers a rail.
  for (const [colour, right, down] of /** @type {const} */ ([[colours.railShade, ...shade], [colours.rail, 0, 0]])) {
    ctx.strokeStyle = colour;
    board.walls.forEach((wall, number) => {
      // A wall has no thickness. The rail of a side lies outside of it, so that balls touch its inner edge.
      const across = sides[number] * (width / 2) + right;
      strokeLine(ctx, px(wall.x1) + across, py(wall.y1) + down, px(wall.x2) + across, py(wall.y2) + down);
    });
  }
}

/**
 * Paints the bins with their multipliers, or with their prizes.
 * @param {Pick<Sheet, "ctx" | "geometry" | "board"> & {look: Pick<Look, "payout">}} sheet
 */
export function paintBins({ ctx, geometry, board, look }) {
  const { multipliers } = board.bins;
  const boxes = multipliers.map((_, bin) => binBox(geometry, board, bin));
  if (boxes.some(({ width }) => width <= 0)) return; // the canvas is not laid out yet, or too narrow
  const colours = multipliers.map((pays, bin) => coloursOf(labelOf(board, bin), look.payout(pays)));
  boxes.forEach((box, bin) => {
    ctx.fillStyle = colours[bin].fill;
    ctx.beginPath();
    ctx.roundRect(box.x, box.y, box.width, box.height, Math.min(8, 0.22 * box.width));
    ctx.fill();
  });
  if (board.bins.labels) {
    const texts = multipliers.map((pays, bin) => labelOf(board, bin)?.text ?? multiplier(pays));
    paintPrizes(ctx, texts.map((text, bin) => ({ text, colours: colours[bin] })), boxes, LABEL_FONT);
    return;
  }
  const { size, texts, every } = labelsFor(ctx, board, boxes);
  const first = Math.floor((multipliers.length - 1) / 2) % every;
  ctx.font = `700 ${size.toFixed(1)}px ${LABEL_FONT}`;
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  boxes.forEach(({ x, y, width, height }, bin) => {
    ctx.fillStyle = colours[bin].ink;
    if ((bin - first) % every === 0) ctx.fillText(texts[bin], x + width / 2, y + height / 2 + 0.06 * size);
  });
}

/** @param {Geometry} geometry @param {Board} board @param {number} bin @returns {Box} CSS pixels */
export function binBox({ px, binTop, binHeight }, board, bin) {
  const from = px(board.bins.edges[bin]);
  const to = px(board.bins.edges[bin + 1]);
  const gap = Math.max(1, Math.min(3, 0.06 * (to - from)));
  return { x: from + gap, y: binTop + 2, width: to - from - 2 * gap, height: binHeight - 4 };
}

/**
 * How the multipliers are lettered: in narrow bins without their "x", and in the narrowest ones, if all pay the same,
 * only in every n-th bin.
 * @param {CanvasRenderingContext2D} ctx @param {Board} board @param {Box[]} boxes
 * @returns {{size: number, texts: string[], every: number}} size: CSS pixels
 */
function labelsFor(ctx, { bins: { multipliers } }, boxes) {
  ctx.font = `700 100px ${LABEL_FONT}`;
  const fitting = (/** @type {string[]} */ texts) => Math.min(0.52 * boxes[0].height, 26, ...texts.map((text, bin) => (
    (FILLED * 100 * boxes[bin].width) / ctx.measureText(text).width)));
  const texts = multipliers.map(multiplier);
  const size = fitting(texts);
  if (size >= LEGIBLE) return { size, texts, every: 1 };
  const bare = texts.map((text) => text.slice(0, -1));
  const larger = fitting(bare);
  if (larger >= LEGIBLE - 1 || new Set(multipliers).size > 1) return { size: larger, texts: bare, every: 1 };
  const wide = (LEGIBLE + 1) * (ctx.measureText(texts[0]).width / 100) + 6;
  return { size: LEGIBLE + 1, texts, every: Math.ceil(wide / boxes[0].width) };
}
