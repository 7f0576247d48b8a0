// Paints one peg: its light, and the mark of its material.

import { disc, strokeLine } from "../util/canvas.js";

/** @import { Mark, Palette, PegShape } from "./theme.js" */

/** @typedef {{x: number, y: number, r: number}} Spot CSS pixels */
/** @typedef {(ctx: CanvasRenderingContext2D, spot: Spot, at: number[]) => void} Shape */

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {Spot} spot
 * @param {Palette} colours
 * @param {PegShape} shape
 */
export function paintPeg(ctx, spot, colours, { highlight, shade, mark = [] }) {
  const { x, y, r } = spot;
  const light = ctx.createRadialGradient(
    x + highlight.x * r, y + highlight.y * r, highlight.radius * r, x, y, r,
  );
  for (const { at, colour } of shade) light.addColorStop(at, colours[colour]);
  ctx.fillStyle = light;
  disc(ctx, x, y, r);
  for (const { shape, at, colour, alpha } of mark) {
    ctx.globalAlpha = alpha;
    ctx.fillStyle = colours[colour];
    ctx.strokeStyle = colours[colour];
    MARKS[shape](ctx, spot, at);
  }
  ctx.globalAlpha = 1;
}

/** Paints one shape of a mark, in the current colour. @type {Record<Mark["shape"], Shape>} */
const MARKS = {
  disc: (ctx, { x, y, r }, [dx, dy, radius]) => disc(ctx, x + dx * r, y + dy * r, radius * r),
  ring: (ctx, { x, y, r }, [radius, wide]) => {
    ctx.lineWidth = wide * r;
    ctx.beginPath();
    ctx.arc(x, y, radius * r, 0, 2 * Math.PI);
    ctx.stroke();
  },
  stripe: (ctx, { x, y, r }, [from, thick]) => {
    ctx.save();
    ctx.beginPath();
    ctx.arc(x, y, r, 0, 2 * Math.PI);
    ctx.clip();
    ctx.fillRect(x - r, y + from * r, 2 * r, thick * r);
    ctx.restore();
  },
  line: (ctx, { x, y, r }, [x1, y1, x2, y2, wide]) => {
    ctx.lineWidth = wide * r;
    strokeLine(ctx, x + x1 * r, y + y1 * r, x + x2 * r, y + y2 * r);
  },
};
