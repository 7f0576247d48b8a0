// Paints what moves: balls with their trails, flashes on pegs, what a bin has just paid.

import { contextOf, disc } from "../util/canvas.js";
import { multiplier } from "../util/format.js";
import { LABEL_FONT } from "./board.js";

/** @import { BallShape, PayoutColour } from "./theme.js" */

const MARGIN = 0.6; // of the radius, around the ball in its stamp: the shadow's room
const HALF_TURN_STEPS = 40; // the band looks the same after half a turn
const FLASH_STEPS = 16;
const HALO = 2.3; // times the ball's radius, and
const LEAST_HALO = 13; // CSS pixels at least

/** @typedef {{body: string, dark: string, light: string, band: string, shadow: string}} BallColours */

/**
 * A ball drawn once per size, colour and angle, then only copied.
 * @typedef {object} Sprite
 * @property {HTMLCanvasElement} sheet one stamp beside the other, by angle
 * @property {number} half half of a stamp's side, CSS pixels
 * @property {number} side a stamp's side, sheet pixels
 */

/**
 * @param {number} radius CSS pixels
 * @param {number} density device pixels per CSS pixel
 * @param {BallColours} colours
 * @param {BallShape} shape
 * @returns {Sprite}
 */
export function makeSprite(radius, density, colours, shape) {
  const side = Math.ceil(2 * (1 + MARGIN) * radius * density + 2);
  const half = side / density / 2;
  const ctx = sheetOf(side, HALF_TURN_STEPS);
  const gloss = glossOf(ctx, radius, colours, shape);
  const { across, down, alpha } = shape.shadow;
  for (let step = 0; step < HALF_TURN_STEPS; step += 1) {
    ctx.setTransform(density, 0, 0, density, (step + 0.5) * side, side / 2);
    ctx.globalAlpha = alpha;
    ctx.fillStyle = colours.shadow;
    disc(ctx, across * radius, down * radius, radius);
    ctx.globalAlpha = 1;
    paintBody(ctx, radius, (step * Math.PI) / HALF_TURN_STEPS, colours, shape.band);
    ctx.fillStyle = gloss;
    disc(ctx, 0, 0, radius);
  }
  return { sheet: ctx.canvas, half, side };
}

/** @param {number} side @param {number} count */
function sheetOf(side, count) {
  const canvas = document.createElement("canvas");
  canvas.width = side * count;
  canvas.height = side;
  return contextOf(canvas);
}

/**
 * The body turns under its light, so the gloss is the same at every angle.
 * @param {CanvasRenderingContext2D} ctx
 * @param {number} radius
 * @param {BallColours} colours
 * @param {BallShape} ballShape
 */
function glossOf(ctx, radius, colours, { highlight, gloss: stops }) {
  const gloss = ctx.createRadialGradient(
    highlight.x * radius, highlight.y * radius, highlight.radius * radius, 0, 0, radius,
  );
  for (const { at, colour, alpha } of stops) {
    gloss.addColorStop(at, colours[colour] + hexByte(alpha));
  }
  return gloss;
}

/** 0 … 1 as the last two digits of #rrggbbaa. @param {number} part */
function hexByte(part) {
  return Math.round(255 * part).toString(16).padStart(2, "0");
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {number} radius
 * @param {number} angle
 * @param {BallColours} ballColours
 * @param {number} half
 */
function paintBody(ctx, radius, angle, { body, band }, half) {
  ctx.fillStyle = body;
  disc(ctx, 0, 0, radius);
  const reach = Math.asin(half);
  ctx.fillStyle = band;
  ctx.beginPath();
  ctx.arc(0, 0, radius, angle - reach, angle + reach);
  ctx.arc(0, 0, radius, angle + Math.PI - reach, angle + Math.PI + reach);
  ctx.fill();
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {Sprite} sprite
 * @param {number} x CSS pixels
 * @param {number} y CSS pixels
 * @param {number} angle radians
 */
export function paintBall(ctx, { sheet, half, side }, x, y, angle) {
  const steps = Math.round((angle * HALF_TURN_STEPS) / Math.PI) % HALF_TURN_STEPS;
  const step = steps < 0 ? steps + HALF_TURN_STEPS : steps;
  ctx.drawImage(sheet, step * side, 0, side, side, x - half, y - half, 2 * half, 2 * half);
}

/**
 * A ribbon that narrows to nothing towards where the ball came from, added to the current path:
 * all ribbons of a colour are filled at once.
 * @param {CanvasRenderingContext2D} ctx
 * @param {Float64Array} points x0 y0 x1 y1 … CSS pixels, newest first
 * @param {number} count points that hold
 * @param {number} width half of it at the ball, CSS pixels
 */
export function traceTrail(ctx, points, count, width) {
  if (count < 3) return;
  edge(ctx, points, count, 0, width, true);
  for (let i = 1; i < count; i += 1) edge(ctx, points, count, i, width, false);
  for (let i = count - 2; i >= 0; i -= 1) edge(ctx, points, count, i, -width, false);
  ctx.closePath();
}

/**
 * One point of the ribbon's outline: aside of point i by what is left of the width there.
 * @param {CanvasRenderingContext2D} ctx
 * @param {Float64Array} points
 * @param {number} count
 * @param {number} i
 * @param {number} width
 * @param {boolean} first
 */
function edge(ctx, points, count, i, width, first) {
  const before = Math.max(0, i - 1);
  const after = Math.min(count - 1, i + 1);
  const dx = points[2 * after] - points[2 * before];
  const dy = points[2 * after + 1] - points[2 * before + 1];
  const length = Math.sqrt(dx * dx + dy * dy) || 1;
  const half = width * (1 - i / (count - 1));
  const x = points[2 * i] - (dy / length) * half;
  const y = points[2 * i + 1] + (dx / length) * half;
  if (first) ctx.moveTo(x, y);
  else ctx.lineTo(x, y);
}

/**
 * The light around a ball: it makes a small one larger to the eye, never to what it touches.
 * @param {number} radius CSS pixels @param {number} density @param {string} colour #rrggbb
 * @returns {Sprite} of one stamp
 */
export function makeHalo(radius, density, colour) {
  const half = Math.max(LEAST_HALO, HALO * radius);
  const side = Math.ceil(2 * half * density);
  const ctx = sheetOf(side, 1);
  ctx.setTransform(density, 0, 0, density, side / 2, side / 2);
  const light = ctx.createRadialGradient(0, 0, 0.6 * radius, 0, 0, half);
  light.addColorStop(0, `${colour}90`);
  light.addColorStop(0.4, `${colour}38`);
  light.addColorStop(1, `${colour}00`);
  ctx.fillStyle = light;
  disc(ctx, 0, 0, half);
  return { sheet: ctx.canvas, half, side };
}

/**
 * Pegs that have just been hit, drawn once for each age at full strength.
 * @param {number} radius of a peg, CSS pixels
 * @param {number} density
 * @param {string} colour
 * @returns {Sprite & {radius: number}}
 */
export function makeFlashes(radius, density, colour) {
  const half = flashRadius(radius, 1) + 1;
  const side = Math.ceil(2 * half * density);
  const ctx = sheetOf(side, FLASH_STEPS);
  for (let step = 0; step < FLASH_STEPS; step += 1) {
    const age = step / FLASH_STEPS;
    const left = (1 - age) ** 2;
    ctx.setTransform(density, 0, 0, density, (step + 0.5) * side, side / 2);
    const glow = ctx.createRadialGradient(0, 0, 0.8 * radius, 0, 0, flashRadius(radius, age));
    glow.addColorStop(0, `${colour}c0`);
    glow.addColorStop(0.4, `${colour}48`);
    glow.addColorStop(1, `${colour}00`);
    ctx.globalAlpha = left;
    ctx.fillStyle = glow;
    disc(ctx, 0, 0, flashRadius(radius, age));
    ctx.fillStyle = colour;
    disc(ctx, 0, 0, radius);
  }
  return { sheet: ctx.canvas, half: side / density / 2, side, radius };
}

/**
 * A peg that has just been hit.
 * @param {CanvasRenderingContext2D} ctx
 * @param {Sprite & {radius: number}} flashes
 * @param {number} x CSS pixels
 * @param {number} y CSS pixels
 * @param {number} radius of the peg, CSS pixels
 * @param {number} age 0 … 1
 * @param {number} strength 0 … 1: a soft touch glows less
 * @returns {number} CSS pixels: how far it reaches
 */
export function paintFlash(ctx, { sheet, half, side, radius: drawn }, x, y, radius, age, strength) {
  const step = Math.min(FLASH_STEPS - 1, Math.floor(age * FLASH_STEPS));
  // A hard impact shines farther and brighter than a soft one.
  const reach = (half * radius * (0.5 + 0.5 * strength)) / drawn;
  ctx.globalAlpha = 0.35 + 0.65 * strength;
  ctx.drawImage(sheet, step * side, 0, side, side, x - reach, y - reach, 2 * reach, 2 * reach);
  ctx.globalAlpha = 1;
  return reach;
}

/**
 * @param {number} radius of the peg, CSS pixels
 * @param {number} age 0 … 1
 * @returns {number} CSS pixels: how far a flash reaches at most
 */
function flashRadius(radius, age) {
  return radius * (2.4 + 2 * Math.sqrt(age)) + 3;
}

/**
 * What a bin has just paid, on a ticket that rises out of it.
 * @param {CanvasRenderingContext2D} ctx
 * @param {number} x middle, CSS pixels
 * @param {number} y middle, CSS pixels
 * @param {number} size of the figures, CSS pixels
 * @param {number} score
 * @param {number} age 0 … 1
 * @param {PayoutColour} colour
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

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {number} x
 * @param {number} y
 * @param {number} width
 * @param {number} height
 */
function ticket(ctx, x, y, width, height) {
  ctx.beginPath();
  ctx.roundRect(x - width / 2, y - height / 2, width, height, 0.3 * height);
  ctx.fill();
}
