// Paints what moves: balls with their trails, flashes on pegs, and the scores that rise from bins.

import { disc, sheetContext } from "../util/canvas.js";
import { LABEL_FONT } from "./board.js";

/** @import { Point } from "../model/board.js" */
/** @import { BallShape, PayoutColour } from "./theme.js" */

const MARGIN = 0.6; // of the radius, around the ball in its stamp, for the shadow
const HALF_TURN_STEPS = 40; // the band looks the same after half a turn
const FLASH_STEPS = 16;
const FLASH_STRENGTHS = 5; // from the softest to the hardest
const HALO = 2.3; // times the ball's radius, and
const LEAST_HALO = 13; // CSS pixels at least

/** @typedef {{body: string, dark: string, light: string, band: string, shadow: string}} BallColours */

/**
 * A ball drawn once for each size, colour and angle; each frame only copies it.
 * @typedef {object} Sprite
 * @property {ImageBitmap} sheet stamps side by side, by angle
 * @property {number} half half of a stamp's side, CSS pixels
 * @property {number} side a stamp's side, sheet pixels
 *
 * @typedef {Sprite & {density: number}} Light density: sheet pixels per CSS pixel
 * @typedef {Light & {radius: number}} Flashes of pegs of this radius, CSS pixels
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
  const ctx = sheetContext(HALF_TURN_STEPS * side, side);
  // The body turns under its light, so the gloss is the same at every angle.
  const { x, y, radius: bright } = shape.highlight;
  const gloss = ctx.createRadialGradient(x * radius, y * radius, bright * radius, 0, 0, radius);
  for (const { at, colour, alpha: part } of shape.gloss) {
    const alpha = Math.round(255 * part).toString(16).padStart(2, "0");
    gloss.addColorStop(at, colours[/** @type {"light" | "dark"} */ (colour)] + alpha);
  }
  const { across, down, alpha } = shape.shadow;
  const band = Math.asin(shape.band);
  for (let step = 0; step < HALF_TURN_STEPS; step += 1) {
    ctx.setTransform(density, 0, 0, density, (step + 0.5) * side, side / 2);
    ctx.globalAlpha = alpha;
    ctx.fillStyle = colours.shadow;
    disc(ctx, across * radius, down * radius, radius);
    ctx.globalAlpha = 1;
    ctx.fillStyle = colours.body;
    disc(ctx, 0, 0, radius);
    ctx.fillStyle = colours.band;
    ctx.beginPath();
    for (const angle of [0, Math.PI].map((half) => half + (step * Math.PI) / HALF_TURN_STEPS)) {
      ctx.arc(0, 0, radius, angle - band, angle + band);
    }
    ctx.fill();
    ctx.fillStyle = gloss;
    disc(ctx, 0, 0, radius);
  }
  return { sheet: ctx.canvas.transferToImageBitmap(), half, side };
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
 * Fills a trail: a ribbon that narrows to nothing, away from the ball. Each trail is filled separately:
 * in one path with all trails, the browser would examine all their edges for every row of pixels.
 * @param {CanvasRenderingContext2D} ctx
 * @param {Point[]} points CSS pixels, newest first
 * @param {number} width half the ribbon's width at the ball, CSS pixels
 */
export function fillTrail(ctx, points, width) {
  const last = points.length - 1;
  if (last < 2) return;
  ctx.beginPath();
  for (let i = 0; i <= last; i += 1) edge(ctx, points, i, width);
  for (let i = last - 1; i >= 0; i -= 1) edge(ctx, points, i, -width);
  ctx.fill();
}

/**
 * Adds a point of the ribbon's outline: point i, shifted sideways by half the ribbon's width there.
 * @param {CanvasRenderingContext2D} ctx @param {Point[]} points @param {number} i @param {number} width
 */
function edge(ctx, points, i, width) {
  const last = points.length - 1;
  const [before, after] = [points[Math.max(0, i - 1)], points[Math.min(last, i + 1)]];
  const [dx, dy] = [after.x - before.x, after.y - before.y];
  const half = (width * (1 - i / last)) / (Math.hypot(dx, dy) || 1);
  ctx.lineTo(points[i].x - dy * half, points[i].y + dx * half);
}

/**
 * The light around a ball. It makes small balls easier to see.
 * @param {number} radius CSS pixels @param {number} density @param {string} colour #rrggbb
 * @returns {Light} of one stamp
 */
export function makeHalo(radius, density, colour) {
  const side = Math.ceil(2 * Math.max(LEAST_HALO, HALO * radius) * density);
  const half = side / density / 2;
  const ctx = sheetContext(side, side);
  ctx.setTransform(density, 0, 0, density, side / 2, side / 2);
  const light = ctx.createRadialGradient(0, 0, 0.6 * radius, 0, 0, half);
  light.addColorStop(0, `${colour}90`);
  light.addColorStop(0.4, `${colour}38`);
  light.addColorStop(1, `${colour}00`);
  ctx.fillStyle = light;
  disc(ctx, 0, 0, half);
  return { sheet: ctx.canvas.transferToImageBitmap(), half, side, density };
}

/**
 * Copies a stamp of light to the nearest whole pixels, which is faster than a copy that interpolates. As
 * light has no sharp edge, the shift is invisible.
 * @param {CanvasRenderingContext2D} ctx scaled to CSS pixels
 * @param {Light} light
 * @param {number} x CSS pixels
 * @param {number} y CSS pixels
 * @param {{column?: number, row?: number, reach?: number}} [which] column and row: the stamp; reach: half of its
 *   side on the canvas, CSS pixels
 */
export function paintLight(ctx, { sheet, half, side, density }, x, y, { column = 0, row = 0, reach = half } = {}) {
  const left = Math.round((x - reach) * density) / density;
  const top = Math.round((y - reach) * density) / density;
  ctx.drawImage(sheet, column * side, row * side, side, side, left, top, 2 * reach, 2 * reach);
}

/**
 * The flashes of pegs, drawn once for each age and strength of the impact.
 * @param {number} radius of a peg, CSS pixels
 * @param {number} density
 * @param {string} colour
 * @returns {Flashes} ages side by side, strengths one below the other
 */
export function makeFlashes(radius, density, colour) {
  const side = Math.ceil(2 * (flashRadius(radius, 1) + 1) * density);
  const ctx = sheetContext(FLASH_STEPS * side, FLASH_STRENGTHS * side);
  for (let row = 0; row < FLASH_STRENGTHS; row += 1) {
    for (let column = 0; column < FLASH_STEPS; column += 1) {
      const strength = row / (FLASH_STRENGTHS - 1);
      // A hard impact shines farther and brighter than a soft one.
      const scale = density * (0.5 + 0.5 * strength);
      ctx.setTransform(scale, 0, 0, scale, (column + 0.5) * side, (row + 0.5) * side);
      stampFlash(ctx, radius, colour, column / FLASH_STEPS, 0.35 + 0.65 * strength);
    }
  }
  return { sheet: ctx.canvas.transferToImageBitmap(), half: side / density / 2, side, density, radius };
}

/**
 * @param {OffscreenCanvasRenderingContext2D} ctx
 * @param {number} radius
 * @param {string} colour
 * @param {number} age 0 … 1
 * @param {number} alpha at age 0
 */
function stampFlash(ctx, radius, colour, age, alpha) {
  const reach = flashRadius(radius, age);
  const glow = ctx.createRadialGradient(0, 0, 0.8 * radius, 0, 0, reach);
  glow.addColorStop(0, `${colour}c0`);
  glow.addColorStop(0.4, `${colour}48`);
  glow.addColorStop(1, `${colour}00`);
  ctx.globalAlpha = alpha * (1 - age) ** 2;
  ctx.fillStyle = glow;
  disc(ctx, 0, 0, reach);
  ctx.fillStyle = colour;
  disc(ctx, 0, 0, radius);
}

/**
 * Paints the flash of a peg.
 * @param {CanvasRenderingContext2D} ctx
 * @param {Flashes} flashes
 * @param {number} x CSS pixels
 * @param {number} y CSS pixels
 * @param {number} radius of the peg, CSS pixels
 * @param {number} age 0 … 1
 * @param {number} strength 0 … 1
 */
export function paintFlash(ctx, flashes, x, y, radius, age, strength) {
  const column = Math.min(FLASH_STEPS - 1, Math.floor(age * FLASH_STEPS));
  const row = Math.round(strength * (FLASH_STRENGTHS - 1));
  const reach = (flashes.half * radius) / flashes.radius;
  paintLight(ctx, flashes, x, y, { column, row, reach });
}

/**
 * @param {number} radius of the peg, CSS pixels
 * @param {number} age 0 … 1
 * @returns {number} the radius of the flash, CSS pixels
 */
function flashRadius(radius, age) {
  return radius * (2.4 + 2 * Math.sqrt(age)) + 3;
}

/**
 * Paints the score of a landing, on a ticket that rises out of the bin.
 * @param {CanvasRenderingContext2D} ctx
 * @param {number} x middle, CSS pixels
 * @param {number} y middle, CSS pixels
 * @param {number} size of the figures, CSS pixels
 * @param {string} text the multiplier, or the prize
 * @param {number} age 0 … 1
 * @param {Pick<PayoutColour, "fill" | "ink">} colour
 * @param {string} shadow
 */
export function paintPaid(ctx, x, y, size, text, age, colour, shadow) {
  ctx.font = `700 ${size}px ${LABEL_FONT}`;
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  const width = ctx.measureText(text).width + 0.9 * size;
  const height = 1.4 * size;
  const alpha = Math.min(1, 4 * (1 - age));
  /** @param {number} across @param {number} down */
  const ticket = (across, down) => {
    ctx.beginPath();
    ctx.roundRect(x - width / 2 + across, y - height / 2 + down, width, height, 0.3 * height);
    ctx.fill();
  };
  ctx.globalAlpha = 0.5 * alpha;
  ctx.fillStyle = shadow;
  ticket(1, 3);
  ctx.globalAlpha = alpha;
  ctx.fillStyle = colour.fill;
  ticket(0, 0);
  ctx.fillStyle = colour.ink;
  ctx.fillText(text, x, y + 0.06 * size);
  ctx.globalAlpha = 1;
}
