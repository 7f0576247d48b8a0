// Paints what moves: balls with their trails, flashes on pegs, what a bin has just paid.

import { multiplier } from "./format.js";
import { LABEL_FONT } from "./paint-board.js";

const SPRITE_MARGIN = 1.1; // of the radius, so that the anti-aliased rim is not cut off

/**
 * A ball drawn once per size and colour, then stamped: the body turns, the gloss does not.
 * @typedef {{body: HTMLCanvasElement, gloss: HTMLCanvasElement, half: number}} Sprite
 */

/**
 * @param {number} radius CSS pixels
 * @param {number} density device pixels per CSS pixel
 * @param {{body: string, dark: string, light: string, band: string}} colours
 * @returns {Sprite} half is half of the stamp's side in CSS pixels
 */
export function makeSprite(radius, density, colours) {
  const half = radius * SPRITE_MARGIN + 1;
  const body = stamp(half, density, (ctx) => {
    ctx.fillStyle = colours.body;
    disc(ctx, 0, 0, radius);
    ctx.clip();
    ctx.fillStyle = colours.band;
    ctx.fillRect(-radius, -0.24 * radius, 2 * radius, 0.48 * radius);
  });
  const gloss = stamp(half, density, (ctx) => {
    const shade = ctx.createRadialGradient(
      -0.35 * radius, -0.4 * radius, 0.1 * radius, 0, 0, radius,
    );
    shade.addColorStop(0, `${colours.light}e6`);
    shade.addColorStop(0.3, `${colours.light}30`);
    shade.addColorStop(0.65, `${colours.dark}00`);
    shade.addColorStop(1, `${colours.dark}d0`);
    ctx.fillStyle = shade;
    disc(ctx, 0, 0, radius);
  });
  return { body, gloss, half };
}

function stamp(half, density, paint) {
  const canvas = document.createElement("canvas");
  canvas.width = Math.ceil(2 * half * density);
  canvas.height = canvas.width;
  const ctx = canvas.getContext("2d");
  ctx.scale(canvas.width / (2 * half), canvas.width / (2 * half));
  ctx.translate(half, half);
  paint(ctx);
  return canvas;
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {Sprite} sprite
 * @param {number} x CSS pixels
 * @param {number} y CSS pixels
 * @param {number} angle radians
 */
export function paintBall(ctx, { body, gloss, half }, x, y, angle) {
  ctx.save();
  ctx.translate(x, y);
  ctx.drawImage(gloss, -half, -half, 2 * half, 2 * half);
  ctx.rotate(angle);
  ctx.drawImage(body, -half, -half, 2 * half, 2 * half);
  ctx.rotate(-angle);
  ctx.drawImage(gloss, -half, -half, 2 * half, 2 * half);
  ctx.restore();
}

/**
 * A ribbon that narrows to nothing towards where the ball came from.
 * @param {CanvasRenderingContext2D} ctx
 * @param {Float64Array} points x0 y0 x1 y1 … CSS pixels, newest first
 * @param {number} count points that hold
 * @param {number} radius of the ball, CSS pixels
 * @param {string} colour
 */
export function paintTrail(ctx, points, count, radius, colour) {
  if (count < 3) return;
  ctx.globalAlpha = 0.4;
  ctx.fillStyle = colour;
  ctx.beginPath();
  for (let i = 0; i < count; i += 1) edge(ctx, points, count, i, radius);
  for (let i = count - 1; i >= 0; i -= 1) edge(ctx, points, count, i, -radius);
  ctx.fill();
  ctx.globalAlpha = 1;
}

/** One point of the ribbon's outline: aside of point i by what is left of the width there. */
function edge(ctx, points, count, i, radius) {
  const before = Math.max(0, i - 1);
  const after = Math.min(count - 1, i + 1);
  const dx = points[2 * after] - points[2 * before];
  const dy = points[2 * after + 1] - points[2 * before + 1];
  const length = Math.hypot(dx, dy) || 1;
  const half = 0.8 * radius * (1 - i / (count - 1));
  ctx.lineTo(points[2 * i] - (dy / length) * half, points[2 * i + 1] + (dx / length) * half);
}

/**
 * A peg that has just been hit.
 * @param {CanvasRenderingContext2D} ctx
 * @param {number} x CSS pixels
 * @param {number} y CSS pixels
 * @param {number} radius of the peg, CSS pixels
 * @param {number} age 0 … 1
 * @param {number} strength 0 … 1
 * @param {string} colour
 */
export function paintFlash(ctx, x, y, radius, age, strength, colour) {
  const left = (1 - age) ** 2;
  ctx.fillStyle = colour;
  ctx.globalAlpha = left;
  disc(ctx, x, y, radius);
  ctx.globalAlpha = 0.5 * left * (0.4 + 0.6 * strength);
  disc(ctx, x, y, flashRadius(radius, age, strength));
  ctx.globalAlpha = 1;
}

/** @returns {number} CSS pixels: how far a flash reaches */
export function flashRadius(radius, age, strength) {
  return radius * (1.3 + (1 + 1.4 * strength) * Math.sqrt(age)) + 1.5;
}

/**
 * What a bin has just paid, on a ticket that rises out of it.
 * @param {CanvasRenderingContext2D} ctx
 * @param {number} x middle, CSS pixels
 * @param {number} y middle, CSS pixels
 * @param {number} size of the figures, CSS pixels
 * @param {number} score
 * @param {number} age 0 … 1
 * @param {import("./theme.js").PayoutColour} colour
 * @param {string} shadow
 */
export function paintPaid(ctx, x, y, size, score, age, colour, shadow) {
  const text = multiplier(score);
  ctx.font = `700 ${size}px ${LABEL_FONT}`;
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  const width = ctx.measureText(text).width + 0.9 * size;
  const height = 1.4 * size;
  const alpha = Math.min(1, 4 * (1 - age));
  ctx.globalAlpha = 0.5 * alpha;
  ctx.fillStyle = shadow;
  ticket(ctx, x + 1, y + 3, width, height);
  ctx.globalAlpha = alpha;
  ctx.fillStyle = colour.fill;
  ticket(ctx, x, y, width, height);
  ctx.fillStyle = colour.ink;
  ctx.fillText(text, x, y + 0.06 * size);
  ctx.globalAlpha = 1;
}

function ticket(ctx, x, y, width, height) {
  ctx.beginPath();
  ctx.roundRect(x - width / 2, y - height / 2, width, height, 0.3 * height);
  ctx.fill();
}

function disc(ctx, x, y, radius) {
  ctx.beginPath();
  ctx.arc(x, y, radius, 0, 2 * Math.PI);
  ctx.fill();
}
