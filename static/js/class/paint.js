// Paints a board of the lesson: pegs and balls above, the histogram with the ideal law under it.

import { disc } from "../util/canvas.js";
import { plain } from "../util/format.js";
import { normalDensity } from "./statistics.js";

/** @import { Board, Point } from "../model/board.js" */
/** @import { Palette } from "../paint/theme.js" */
/** @import { Summary } from "./statistics.js" */

/**
 * @typedef {object} Geometry
 * @property {number} width CSS pixels
 * @property {number} height
 * @property {number} font
 * @property {number} scale CSS pixels per metre
 * @property {number} top of the histogram
 * @property {number} bottom of the histogram
 * @property {(x: number) => number} px
 * @property {(y: number) => number} py
 * @property {number[]} edges of the bars, CSS pixels
 *
 * @typedef {object} Picture
 * @property {(Point & {other: boolean})[]} balls
 * @property {Point[][]} paths of the two balls a hair apart
 * @property {number[]} counts
 * @property {number[]} due expected counts
 * @property {Summary | null} law null to show none
 * @property {number[] | null} guess heights
 * @property {boolean} secret whether the counts are hidden, as the pupils still guess
 * @property {number | null} cursor the bin that keys change
 */

const FAMILY = '"Segoe UI", "Helvetica Neue", "Liberation Sans", Arial, sans-serif';
const SHARE = 0.4; // of the height, for the histogram
const ABOVE = 1.6; // metres of free height above the first row, in distances of the rows

/** @param {Board} board @param {{width: number, height: number, font: number}} size @returns {Geometry} */
export function layOut({ bins, walls, pegs, ball }, { width, height, font }) {
  const xs = [...bins.edges, ...walls.flatMap(({ x1, x2 }) => [x1, x2])];
  const [left, right] = [Math.min(...xs), Math.max(...xs)];
  const start = -ABOVE * (pegs[3].y - pegs[0].y);
  const down = bins.y - start + ball.radius;
  const scale = Math.min((width - font) / (right - left), ((1 - SHARE) * height) / down);
  const px = (/** @type {number} */ x) => width / 2 + (x - (left + right) / 2) * scale;
  const [, second, third] = bins.edges;
  const inner = bins.edges.slice(1, -1);
  const step = third - second; // the outer bins are wider, up to the walls; all bars are equally wide
  return {
    width, height, font, scale, px, py: (y) => (y - start) * scale,
    top: down * scale + 2.2 * font, bottom: height - 1.7 * font,
    edges: [second - step, ...inner, inner[inner.length - 1] + step].map(px),
  };
}

/** @param {CanvasRenderingContext2D} ctx @param {Board} board @param {Geometry} geometry @param {Palette} palette @param {Picture} picture */
export function paintTrial(ctx, board, geometry, palette, picture) {
  const { width, height, top, font, px, py, scale } = geometry;
  ctx.fillStyle = palette.board;
  ctx.fillRect(0, 0, width, top - 2 * font);
  ctx.fillStyle = palette.tray;
  ctx.fillRect(0, top - 2 * font, width, height);
  ctx.fillStyle = palette.peg;
  for (const { x, y, radius } of board.pegs) disc(ctx, px(x), py(y), radius * scale);
  ctx.strokeStyle = palette.rail;
  ctx.lineWidth = Math.max(2, 0.003 * scale);
  ctx.lineCap = "round";
  ctx.beginPath();
  for (const { x1, y1, x2, y2 } of board.walls) {
    ctx.moveTo(px(x1), py(y1));
    ctx.lineTo(px(x2), py(y2));
  }
  ctx.stroke();
  const colours = [palette.ball, palette.other];
  picture.paths.forEach((path, i) => {
    ctx.strokeStyle = colours[i];
    ctx.lineWidth = 2;
    ctx.beginPath();
    for (const { x, y } of path) ctx.lineTo(px(x), py(y));
    ctx.stroke();
  });
  // Rings tell balls apart where many are in the same place.
  const radius = board.ball.radius * scale;
  ctx.lineWidth = 0.15 * radius;
  for (const { x, y, other } of picture.balls) {
    ctx.fillStyle = colours[Number(other)];
    ctx.strokeStyle = other ? palette.otherDark : palette.ballDark;
    disc(ctx, px(x), py(y), radius - ctx.lineWidth / 2);
    ctx.stroke();
  }
  paintHistogram(ctx, geometry, palette, picture);
}

/** @param {CanvasRenderingContext2D} ctx @param {Geometry} geometry @param {Palette} palette @param {Picture} picture */
function paintHistogram(ctx, { top, bottom, font, edges }, palette, { counts, due, law, guess, secret, cursor }) {
  const n = counts.reduce((total, count) => total + count, 0);
  const guessed = guess ? guess.reduce((total, each) => total + each, 0) : 0;
  // Without balls, the guess is drawn as it was made; then both have as many balls.
  const own = guess?.map((each) => (n && !secret && guessed ? (each * n) / guessed : each)) ?? [];
  const most = secret ? 100 : Math.max(4, ...counts, ...(n && law ? due : []), ...(n ? own : [100]));
  const unit = (bottom - top) / most;
  const gap = Math.min(3, 0.06 * (edges[2] - edges[1]));
  ctx.textAlign = "center";
  ctx.textBaseline = "alphabetic";
  ctx.font = `600 ${font}px ${FAMILY}`;
  const wide = ctx.measureText(plain(Math.max(...counts))).width < edges[2] - edges[1];
  counts.forEach((count, bin) => {
    const [left, right] = [edges[bin] + gap, edges[bin + 1] - gap];
    const middle = (left + right) / 2;
    ctx.fillStyle = palette.trayInk;
    if (bin % every(ctx, counts.length, right - left) === 0) ctx.fillText(String(bin), middle, bottom + 1.3 * font);
    if (!secret) {
      ctx.fillStyle = palette.trayBar;
      ctx.fillRect(left, bottom - count * unit, right - left, count * unit);
      // The count stands in the bar, or above it where bar or mark are too low for that.
      const ends = law ? [count, due[bin]] : [count];
      const inside = unit * Math.min(...ends) > 1.8 * font;
      ctx.fillStyle = inside ? palette.tray : palette.trayInk;
      if (count && wide) ctx.fillText(plain(count), middle, bottom - (inside ? 0 : unit * Math.max(...ends)) - 0.5 * font);
    }
    if (!guess) return;
    ctx.strokeStyle = bin === cursor ? palette.trayMark : palette.flash;
    ctx.lineWidth = bin === cursor ? 4 : 2;
    ctx.setLineDash([5, 4]);
    ctx.strokeRect(left, bottom - own[bin] * unit, right - left, own[bin] * unit);
    ctx.setLineDash([]);
  });
  ctx.fillStyle = palette.trayInk;
  ctx.fillRect(edges[0], bottom, edges[edges.length - 1] - edges[0], 1);
  if (n && law && !secret) paintLaw(ctx, { bottom, unit, edges, gap }, palette, due, law, n);
}

/**
 * The expected counts as marks, and the normal curve through them.
 * @param {CanvasRenderingContext2D} ctx
 * @param {{bottom: number, unit: number, edges: number[], gap: number}} place
 * @param {Palette} palette @param {number[]} due @param {Summary} law @param {number} n
 */
function paintLaw(ctx, { bottom, unit, edges, gap }, palette, due, law, n) {
  ctx.strokeStyle = palette.trayMark;
  ctx.lineWidth = 3;
  ctx.lineCap = "butt";
  ctx.beginPath();
  due.forEach((count, bin) => {
    ctx.moveTo(edges[bin] + gap, bottom - count * unit);
    ctx.lineTo(edges[bin + 1] - gap, bottom - count * unit);
  });
  ctx.stroke();
  const step = edges[2] - edges[1];
  ctx.lineWidth = 2;
  ctx.strokeStyle = palette.ballLight;
  ctx.beginPath();
  for (let bin = -0.5; bin <= due.length - 0.5; bin += 0.1) {
    ctx.lineTo(edges[1] + (bin - 0.5) * step, bottom - n * normalDensity(bin, law) * unit);
  }
  ctx.stroke();
}

/** @param {CanvasRenderingContext2D} ctx @param {number} bins @param {number} width of a bin @returns {number} every n-th bin has a number */
function every(ctx, bins, width) {
  const wide = ctx.measureText(String(bins)).width + 4;
  return [1, 2, 5].find((n) => n * width >= wide) ?? 10;
}

/** @param {Geometry} geometry @param {number} x CSS pixels @returns {number} the bin above or below which x is; -1 outside */
export function binAt({ edges }, x) {
  return edges.findIndex((edge, i) => x >= edge && x < edges[i + 1]);
}
