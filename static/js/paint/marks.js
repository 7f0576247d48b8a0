// Paints marks that explain a drop over its board: paths, arrows, rings, notes. CSS pixels.

import { LABEL_FONT } from "./board.js";

/** @import { Geometry } from "./geometry.js" */
/** @import { Point } from "../model/board.js" */
/** @import { Palette } from "./theme.js" */

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {Pick<Geometry, "px" | "py">} geometry
 * @param {Point[]} points metres
 * @param {{colour: string, width: number, alpha?: number, dash?: number[]}} style
 */
export function paintPath(ctx, { px, py }, points, { colour, width, alpha = 1, dash = [] }) {
  ctx.save();
  ctx.strokeStyle = colour;
  ctx.globalAlpha = alpha;
  ctx.lineWidth = width;
  ctx.lineJoin = "round";
  ctx.lineCap = "round";
  ctx.setLineDash(dash);
  ctx.beginPath();
  for (const { x, y } of points) ctx.lineTo(px(x), py(y));
  ctx.stroke();
  ctx.restore();
}

/**
 * An arrow with a dark rim, so that it is visible on any board.
 * @param {CanvasRenderingContext2D} ctx
 * @param {Point} from
 * @param {Point} by from its start to its tip, CSS pixels
 * @param {{colour: string, rim: string, width: number}} style
 */
export function paintArrow(ctx, from, by, { colour, rim, width }) {
  const length = Math.hypot(by.x, by.y);
  if (length < 1) return;
  const [ux, uy] = [by.x / length, by.y / length];
  const head = Math.min(0.7 * length, 2.4 * width + 3);
  /** @param {number} along @param {number} aside @returns {[number, number]} */
  const at = (along, aside) => [
    from.x + ux * along - uy * aside,
    from.y + uy * along + ux * aside,
  ];
  const half = width / 2;
  ctx.beginPath();
  ctx.moveTo(...at(0, half));
  ctx.lineTo(...at(length - head, half));
  ctx.lineTo(...at(length - head, 0.62 * head));
  ctx.lineTo(...at(length, 0));
  ctx.lineTo(...at(length - head, -0.62 * head));
  ctx.lineTo(...at(length - head, -half));
  ctx.lineTo(...at(0, -half));
  ctx.closePath();
  ctx.lineJoin = "round";
  ctx.strokeStyle = rim;
  ctx.lineWidth = 3;
  ctx.stroke();
  ctx.fillStyle = colour;
  ctx.fill();
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {number} x
 * @param {number} y
 * @param {number} radius
 * @param {{colour: string, width: number, dash?: number[]}} style
 */
export function paintRing(ctx, x, y, radius, { colour, width, dash = [] }) {
  ctx.save();
  ctx.setLineDash(dash);
  ctx.strokeStyle = colour;
  ctx.lineWidth = width;
  ctx.beginPath();
  ctx.arc(x, y, radius, 0, 2 * Math.PI);
  ctx.stroke();
  ctx.restore();
}

/**
 * A few words on a label next to a place, kept within the picture.
 * @param {CanvasRenderingContext2D} ctx
 * @param {string} text
 * @param {{x: number, y: number, gap: number, size: number, width: number}} place CSS pixels; gap:
 *   from the place to the words, width: of the picture
 * @param {Palette} palette
 */
export function paintNote(ctx, text, { x, y, gap, size, width }, { railShade, flash }) {
  ctx.save();
  ctx.font = `600 ${size}px ${LABEL_FONT}`;
  ctx.textAlign = "left";
  ctx.textBaseline = "middle";
  const long = ctx.measureText(text).width + size;
  const left = x + gap + long < width ? x + gap : Math.max(0, x - gap - long);
  ctx.globalAlpha = 0.82;
  ctx.fillStyle = railShade;
  ctx.beginPath();
  ctx.roundRect(left, y - 0.85 * size, long, 1.7 * size, 0.4 * size);
  ctx.fill();
  ctx.globalAlpha = 1;
  ctx.fillStyle = flash;
  ctx.fillText(text, left + size / 2, y);
  ctx.restore();
}
