// Canvases: their context, their size in device pixels, and what several painters draw alike.

import { t } from "../texts/text.js";

/** @param {HTMLCanvasElement} canvas @returns {CanvasRenderingContext2D} */
export function contextOf(canvas) {
  const ctx = canvas.getContext("2d");
  if (!ctx) throw new Error(t("page.no-canvas"));
  return ctx;
}

/**
 * To draw on what is then only copied, as the bitmap it is made into: from a canvas each copy would cost far more.
 * @param {number} width pixels @param {number} height pixels
 * @returns {OffscreenCanvasRenderingContext2D}
 */
export function sheetContext(width, height) {
  const ctx = new OffscreenCanvas(width, height).getContext("2d");
  if (!ctx) throw new Error(t("page.no-canvas"));
  return ctx;
}

/**
 * A canvas cleared, as large as it should be, scaled to CSS pixels.
 * @param {HTMLCanvasElement} canvas
 * @param {{width: number, height: number}} size CSS pixels
 * @returns {CanvasRenderingContext2D}
 */
export function fitted(canvas, { width, height }) {
  const density = window.devicePixelRatio || 1;
  const [across, down] = [Math.round(width * density), Math.round(height * density)];
  // A canvas is made anew only when its size has changed: that is dear.
  if (canvas.width !== across || canvas.height !== down) {
    canvas.width = across;
    canvas.height = down;
  }
  const ctx = contextOf(canvas);
  ctx.setTransform(density, 0, 0, density, 0, 0);
  ctx.clearRect(0, 0, width, height);
  return ctx;
}

/** @returns {number} how much larger than on a desk things are to be: the page's text size over 16 px */
export function zoom() {
  return parseFloat(getComputedStyle(document.documentElement).fontSize) / 16;
}

/**
 * @param {CanvasPath & CanvasDrawPath} ctx
 * @param {number} x
 * @param {number} y
 * @param {number} radius
 */
export function disc(ctx, x, y, radius) {
  ctx.beginPath();
  ctx.arc(x, y, radius, 0, 2 * Math.PI);
  ctx.fill();
}
