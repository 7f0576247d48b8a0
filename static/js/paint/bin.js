// Paints the light of a bin that a ball has just hit: the more the bin pays, the brighter and higher.

import { sheetContext } from "../util/canvas.js";

/** @import { Theme } from "./theme.js" */
/** @import { Box } from "./board.js" */

/** @typedef {{picture: ImageBitmap, top: number}} Faces picture: the bins at rest; top: how many rows of
 *  the board's pixels lie above it */

/** @typedef {{strength: number, glow: number, press: number}} Pulse strength and glow 0 … 1; press: how far
 *  the bin is pressed down, -1 … 1 */

const SWINGS = 3; // how often the bin swings up and down while it shines

/**
 * @param {number} score
 * @param {number} age 0 … 1 since the landing
 * @returns {Pulse} strength follows from the score: 0 for 0.2 or less, 1 for 1,000 or more
 */
export function pulseOf(score, age) {
  const strength = Math.max(0, Math.min(1, (Math.log10(Math.max(score, 1e-6)) + 0.7) / 3.7));
  const beats = 1 + Math.round(4 * strength);
  const fade = (1 - Math.max(0, Math.min(1, age))) ** 2;
  // The bin moves like a damped spring.
  const press = fade * (1 - age) * Math.cos(2 * Math.PI * SWINGS * age);
  return { strength, glow: fade * (0.6 + 0.4 * Math.cos(2 * Math.PI * beats * age)), press };
}

/** @param {Pick<Box, "height">} box @param {Pulse} pulse @returns {number} CSS pixels */
export function beamHeight({ height }, { strength }) {
  return strength < 0.2 ? 0 : 5 * strength * height;
}

/**
 * A picture of the bins to copy from.
 * @param {HTMLCanvasElement} still the painted board
 * @param {number} top where the bins begin, in its pixels
 * @returns {Faces}
 */
export function facesOf(still, top) {
  const ctx = sheetContext(still.width, still.height - top);
  ctx.drawImage(still, 0, -top);
  return { picture: ctx.canvas.transferToImageBitmap(), top };
}

/**
 * @param {CanvasRenderingContext2D} ctx scaled to CSS pixels
 * @param {Faces} faces
 * @param {Box} box
 * @param {Pulse} pulse
 * @param {Theme} theme
 * @param {number} density of the faces
 * @param {number} score
 */
export function paintPulse(ctx, { picture, top }, box, pulse, theme, density, score) {
  const { x, y, width, height } = box;
  const { strength, glow } = pulse;
  paintBeam(ctx, box, pulse, theme.payout(score).fill);
  const press = pulse.press * (4 + 7 * strength);
  ctx.fillStyle = theme.palette.railShade;
  ctx.fillRect(x - 1, y - 1, width + 2, Math.max(0, press) + 2);
  ctx.drawImage(
    picture, x * density, y * density - top, width * density, height * density, x, y + press, width, height,
  );
  // Only the rim is lit, so that the number stays readable.
  ctx.globalAlpha = glow;
  ctx.strokeStyle = theme.palette.flash;
  ctx.lineWidth = 2 + 3 * strength;
  ctx.beginPath();
  ctx.roundRect(x, y + press, width, height, Math.min(8, 0.22 * width));
  ctx.stroke();
  ctx.globalAlpha = 1;
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {Box} box
 * @param {Pulse} pulse
 * @param {string} colour
 */
function paintBeam(ctx, box, pulse, colour) {
  const reach = beamHeight(box, pulse);
  if (reach === 0) return;
  const { x, y, width } = box;
  const light = ctx.createLinearGradient(0, y, 0, y - reach);
  light.addColorStop(0, `${colour}b0`);
  light.addColorStop(1, `${colour}00`);
  ctx.globalAlpha = pulse.glow;
  ctx.fillStyle = light;
  ctx.fillRect(x, y - reach, width, reach);
  ctx.globalAlpha = 1;
}
