// Helpers for canvases: contexts, sizes in device pixels, and discs.

import { t } from "../texts/text.js";

/** @param {HTMLCanvasElement} canvas @returns {CanvasRenderingContext2D} */
export function contextOf(canvas) {
  const ctx = canvas.getContext("2d");
  if (!ctx) throw new Error(t("page.no-canvas"));
  return ctx;
}

/**
 * A canvas for pictures that are drawn once and then copied often. Turn it into an ImageBitmap: copies
 * from a bitmap are far cheaper than from a canvas.
 * @param {number} width pixels @param {number} height pixels
 * @returns {OffscreenCanvasRenderingContext2D}
 */
export function sheetContext(width, height) {
  const ctx = new OffscreenCanvas(width, height).getContext("2d");
  if (!ctx) throw new Error(t("page.no-canvas"));
  return ctx;
}

/**
 * Clears a canvas, fits it to a size, and scales it to CSS pixels.
 * @param {HTMLCanvasElement} canvas
 * @param {{width: number, height: number}} size CSS pixels
 * @returns {CanvasRenderingContext2D}
 */
export function fitted(canvas, { width, height }) {
  const density = window.devicePixelRatio || 1;
  const [across, down] = [Math.round(width * density), Math.round(height * density)];
  // Setting the size reallocates the canvas even if it is the same, which is expensive.
  if (canvas.width !== across || canvas.height !== down) {
    canvas.width = across;
    canvas.height = down;
  }
  const ctx = contextOf(canvas);
  ctx.setTransform(density, 0, 0, density, 0, 0);
  ctx.clearRect(0, 0, width, height);
  return ctx;
}

/** @returns {number} the page's text size divided by 16 px, by which marks are enlarged */
export function zoom() {
  return parseFloat(getComputedStyle(document.documentElement).fontSize) / 16;
}

/** Fills a disc. @param {CanvasPath & CanvasDrawPath} ctx @param {number} x @param {number} y @param {number} radius */
export function disc(ctx, x, y, radius) {
  ctx.beginPath();
  ctx.arc(x, y, radius, 0, 2 * Math.PI);
  ctx.fill();
}

/**
 * Strokes a straight line.
 * @param {CanvasPath & CanvasDrawPath} ctx @param {number} x1 @param {number} y1 @param {number} x2 @param {number} y2
 */
export function strokeLine(ctx, x1, y1, x2, y2) {
  ctx.beginPath();
  ctx.moveTo(x1, y1);
  ctx.lineTo(x2, y2);
  ctx.stroke();
}
