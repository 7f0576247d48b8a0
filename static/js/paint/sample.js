// Paints a small sample of a table's look: its backdrop, some pegs and a ball.

import { makeSprite, paintBall } from "./ball.js";
import { GROUNDS, paintEnamel } from "./ground.js";
import { paintPeg } from "./peg.js";
import { disc } from "../util/canvas.js";

/** @import { Look } from "./theme.js" */

const PEGS = [[0.2, 0.86], [0.5, 0.86], [0.8, 0.86], [0.35, 0.46], [0.65, 0.46]]; // parts of width and height
const PEG = 0.085; // of the width
const BALL = { x: 0.5, y: 0.24, radius: 0.1, angle: 0.7 };

/**
 * @param {CanvasRenderingContext2D} ctx scaled to CSS pixels
 * @param {{width: number, height: number}} size CSS pixels
 * @param {number} density
 * @param {Look} look
 */
export function paintSample(ctx, { width, height }, density, { palette: colours, shapes, ground, grounds }) {
  paintEnamel(ctx, colours, width, height);
  ctx.save();
  GROUNDS[ground](ctx, { x: width / 2, y: 0, width, height, colours, rays: shapes.rays, grounds });
  ctx.restore();
  const { across, down, alpha } = shapes.peg.shadow;
  const r = PEG * width;
  for (const [x, y] of PEGS.map(([part, deep]) => [part * width, deep * height])) {
    ctx.globalAlpha = alpha;
    ctx.fillStyle = colours.shadow;
    disc(ctx, x + across * r, y + down * r, r);
    ctx.globalAlpha = 1;
    paintPeg(ctx, { x, y, r }, colours, shapes.peg);
  }
  const { ball: body, ballDark: dark, ballLight: light, ballBand: band, shadow } = colours;
  const sprite = makeSprite(BALL.radius * width, density, { body, dark, light, band, shadow }, shapes.ball);
  paintBall(ctx, sprite, BALL.x * width, BALL.y * height, BALL.angle);
}
