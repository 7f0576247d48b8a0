// Paints the marks over the edited board: grid, handles, selection, problems, selection band, cross.

import { binBox } from "../paint/board.js";
import { paintRing } from "../paint/marks.js";
import { strokeLine, zoom } from "../util/canvas.js";
import { placeOf } from "./draft/element.js";
import { membersOf } from "./draft/group.js";

/** @import { Board, Point } from "../model/board.js" */
/** @import { Geometry } from "../paint/geometry.js" */
/** @import { Palette } from "../paint/theme.js" */
/** @import { ElementRef, Ref } from "./draft/element.js" */
/** @import { Band } from "./pointer.js" */

const LEAST_GRID = 9; // smallest distance between the grid's dots, CSS pixels
const KNOB = 5; // its radius, CSS pixels at the usual text size
/** How far the knobs of the bins' edges reach below the bins, so that they cover no multiplier, CSS pixels. */
export const BELOW = 2 * KNOB + 3;

/** @typedef {{ctx: CanvasRenderingContext2D, board: Board, geometry: Geometry}} Sheet */
/**
 * @typedef {{colour: string, width: number}} Look width: CSS pixels at the usual text size
 * @param {Sheet} sheet
 * @param {Band} band
 * @param {Palette} palette
 */

export function paintBand({ ctx, geometry }, { x0, y0, x1, y1 }, { flash }) {
  const { px, py } = geometry;
  /** @type {[number, number, number, number]} */
  const box = [px(x0), py(y0), px(x1) - px(x0), py(y1) - py(y0)];
  ctx.fillStyle = flash;
  ctx.globalAlpha = 0.12;
  ctx.fillRect(...box);
  ctx.globalAlpha = 1;
  ctx.strokeStyle = flash;
  ctx.lineWidth = 1.5 * zoom();
  ctx.setLineDash([6 * zoom(), 4 * zoom()]);
  ctx.strokeRect(...box);
  ctx.setLineDash([]);
}

/** @param {Sheet} sheet @param {number} step @param {string} colour */
export function paintGrid({ ctx, geometry }, step, colour) {
  const { px, py, x, scale, width, height } = geometry;
  let wide = step;
  while (wide * scale < LEAST_GRID) wide *= 2;
  ctx.fillStyle = colour;
  ctx.globalAlpha = 0.22;
  const top = -py(0) / scale;
  for (let i = Math.ceil(x(0) / wide); i * wide < x(width); i += 1) {
    for (let j = Math.ceil(top / wide); py(j * wide) < height; j += 1) {
      ctx.fillRect(px(i * wide) - 0.75, py(j * wide) - 0.75, 1.5, 1.5);
    }
  }
  ctx.globalAlpha = 1;
}

/**
 * Paints the handles for dragging: wall ends, edges between bins, the start.
 * @param {Sheet} sheet
 * @param {Palette} palette
 */
export function paintHandles({ ctx, board, geometry }, palette) {
  const { px, py, scale } = geometry;
  const { walls, bins, drop, ball } = board;
  ctx.fillStyle = palette.flash;
  ctx.strokeStyle = palette.railShade;
  ctx.lineWidth = 1.5;
  /** @param {number} x @param {number} y @param {number} [size] CSS pixels */
  const knob = (x, y, size = KNOB * zoom()) => {
    ctx.beginPath();
    ctx.arc(x, y, size, 0, 2 * Math.PI);
    ctx.fill();
    ctx.stroke();
  };
  for (const { x1, y1, x2, y2 } of walls) {
    knob(px(x1), py(y1));
    knob(px(x2), py(y2));
  }
  const narrowest = Math.min(...bins.edges.slice(1).map((edge, i) => (edge - bins.edges[i]) * scale));
  for (const edge of bins.edges) knob(px(edge), edgeY(geometry), Math.min(KNOB * zoom(), 0.45 * narrowest));
  const ring = { colour: palette.flash, width: 2 * zoom(), dash: [4 * zoom(), 3 * zoom()] };
  paintRing(ctx, px(drop.x), py(drop.y), Math.max(5, ball.radius * scale), ring);
}

/** @param {Geometry} geometry @returns {number} where the knobs of the bins' edges are, CSS pixels */
const edgeY = ({ binTop, binHeight }) => binTop + binHeight + KNOB;

/** @param {Sheet} sheet @param {Ref} ref @param {Look} look */
export function paintAround({ ctx, board, geometry }, ref, look) {
  for (const one of membersOf(ref)) paintAroundOne({ ctx, board, geometry }, one, look);
}

/** @param {Sheet} sheet @param {ElementRef} ref @param {Look} look */
function paintAroundOne({ ctx, board, geometry }, ref, { colour, width }) {
  const { px, py, scale } = geometry;
  const { x, y } = placeOf(board, ref);
  ctx.strokeStyle = colour;
  ctx.lineWidth = width * zoom();
  ctx.lineCap = "round";
  ctx.beginPath();
  if (ref.kind === "wall" && !ref.end) {
    const { x1, y1, x2, y2 } = board.walls[ref.index];
    ctx.moveTo(px(x1), py(y1));
    ctx.lineTo(px(x2), py(y2));
  } else if (ref.kind === "bin") {
    const box = binBox(geometry, board, ref.index);
    ctx.rect(box.x, box.y, box.width, box.height);
  } else {
    const own = ref.kind === "drop" ? board.ball.radius : 0;
    const size = ref.kind === "peg" ? board.pegs[ref.index].radius : own;
    const atY = ref.kind === "edge" ? edgeY(geometry) : py(y);
    ctx.arc(px(x), atY, Math.max(8 * zoom(), size * scale + 5 * zoom()), 0, 2 * Math.PI);
  }
  ctx.stroke();
}

/** @param {Sheet} sheet @param {Point} point @param {Palette} palette */
export function paintCursor({ ctx, geometry }, { x, y }, { flash, railShade }) {
  const { px, py } = geometry;
  for (const line of [{ colour: railShade, width: 4 }, { colour: flash, width: 2 }]) {
    ctx.strokeStyle = line.colour;
    ctx.lineWidth = line.width;
    strokeLine(ctx, px(x) - 12, py(y), px(x) + 12, py(y));
    strokeLine(ctx, px(x), py(y) - 12, px(x), py(y) + 12);
  }
}
