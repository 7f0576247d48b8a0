// Paints one peg: its light, and the mark of what it is made of.

import { disc } from "../util/canvas.js";

/** @import { Palette, PegShape } from "./theme.js" */

/** @typedef {{x: number, y: number, r: number}} Spot CSS pixels */

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {Spot} spot
 * @param {Palette} colours
 * @param {PegShape} shape
 */
export function paintPeg(ctx, spot, colours, { highlight, shade, mark }) {
  const { x, y, r } = spot;
  const light = ctx.createRadialGradient(
    x + highlight.x * r, y + highlight.y * r, highlight.radius * r, x, y, r,
  );
  for (const { at, colour } of shade) light.addColorStop(at, colours[colour]);
  ctx.fillStyle = light;
  disc(ctx, x, y, r);
  if (mark) MARKS[mark](ctx, spot, colours);
}

/** @type {Record<string, (ctx: CanvasRenderingContext2D, spot: Spot, colours: Palette) => void>} */
const MARKS = {
  /** Rock: two craters. */
  craters: (ctx, { x, y, r }, { pegDark }) => {
    ctx.globalAlpha = 0.45;
    ctx.fillStyle = pegDark;
    disc(ctx, x + 0.3 * r, y + 0.12 * r, 0.24 * r);
    disc(ctx, x - 0.22 * r, y + 0.42 * r, 0.15 * r);
    ctx.globalAlpha = 1;
  },
  /** Sandstone, or a planet of gas: stripes across. */
  bands: (ctx, { x, y, r }, { pegDark }) => {
    ctx.save();
    ctx.beginPath();
    ctx.arc(x, y, r, 0, 2 * Math.PI);
    ctx.clip();
    ctx.globalAlpha = 0.38;
    ctx.fillStyle = pegDark;
    for (const [from, thick] of [[-0.45, 0.22], [0.05, 0.34], [0.62, 0.2]]) {
      ctx.fillRect(x - r, y + from * r, 2 * r, thick * r);
    }
    ctx.restore();
  },
  /** Glass: seen through, with a bright edge and a glint. */
  rim: (ctx, { x, y, r }, { pegLight, board }) => {
    ctx.globalAlpha = 0.5;
    ctx.fillStyle = board;
    disc(ctx, x + 0.05 * r, y + 0.05 * r, 0.62 * r);
    ctx.globalAlpha = 0.95;
    ctx.strokeStyle = pegLight;
    ctx.lineWidth = 0.13 * r;
    ctx.beginPath();
    ctx.arc(x, y, 0.87 * r, 0, 2 * Math.PI);
    ctx.stroke();
    ctx.fillStyle = pegLight;
    disc(ctx, x - 0.34 * r, y - 0.36 * r, 0.2 * r);
    ctx.globalAlpha = 1;
  },
  /** Steel: a screw's slot. */
  slot: (ctx, { x, y, r }, { pegDark }) => {
    ctx.globalAlpha = 0.75;
    ctx.strokeStyle = pegDark;
    ctx.lineWidth = 0.2 * r;
    ctx.beginPath();
    ctx.moveTo(x - 0.48 * r, y + 0.3 * r);
    ctx.lineTo(x + 0.48 * r, y - 0.3 * r);
    ctx.stroke();
    ctx.globalAlpha = 1;
  },
  /** Rubber: a ring about a core of another colour. */
  core: (ctx, { x, y, r }, { trayBar }) => {
    ctx.fillStyle = trayBar;
    disc(ctx, x, y, 0.36 * r);
  },
};
