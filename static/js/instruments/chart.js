// A chart over time or count: areas, lines, ticks for events, and one marked place.

import { figure, powerText, powerTicks, ticks } from "../util/scale.js";
import { disc, fitted, strokeLine, sheetContext } from "../util/canvas.js";

/** @import { Palette, Theme } from "../paint/theme.js" */
/** @import { Point } from "../model/board.js" */

const FAMILY = '"Segoe UI", "Helvetica Neue", "Liberation Sans", Arial, sans-serif';
const MARGIN = { left: 3.7, right: 1, top: 1.6, bottom: 1.9 }; // in font sizes
const LIMIT_LINES = 3; // in font sizes: a lower plot does not name its limit

/**
 * @typedef {object} Plot
 * @property {{from: number, to: number, unit: string, log?: boolean}} x
 * @property {{from: number, to: number, unit: string, log?: boolean}} y
 * @property {Curve[]} series
 * @property {number[]} [events] places on x
 * @property {Limit} [limit]
 *
 * @typedef {{y: number, text: string}} Limit
 *
 * @typedef {object} Curve
 * @property {Point[]} points
 * @property {string} colour its name in theme.json
 * @property {number} [width] CSS pixels
 * @property {number} [alpha]
 * @property {Point[]} [base] lower edge of the area to fill
 * @property {boolean} [dots]
 *
 * @typedef {{width: number, height: number, font: number,
 *   margin: {left: number, right: number, top: number, bottom: number}}} Size CSS pixels
 * @typedef {{px: (x: number) => number, py: (y: number) => number, x: (px: number) => number}} Scales
 *
 * @typedef {Size & Scales & {ctx: OffscreenCanvasRenderingContext2D, palette: Palette}} Sheet
 */

/** Draws a plot on a canvas; `onPick(x)` is called when the visitor clicks or drags. */
export class Chart {
  /** @type {Plot | null} */
  #plot = null;
  /** @type {number | null} */
  #mark = null;
  /** The plot without its mark, which alone moves. @type {OffscreenCanvasRenderingContext2D | null} */
  #still = null;
  /** Measured once for each size, as measuring makes the browser lay the page out. @type {Size | null} */
  #measured = null;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Theme} theme
   * @param {(x: number) => void} [onPick]
   */
  constructor(canvas, theme, onPick) {
    this.canvas = canvas;
    this.theme = theme;
    new ResizeObserver(() => {
      this.#measured = null;
      this.#still = null;
      this.#paint();
    }).observe(canvas);
    theme.onChange(() => this.#paint());
    if (onPick) this.#followPointer(onPick);
  }

  /** @param {Plot} plot */
  set(plot) {
    this.#plot = plot;
    this.#paint();
  }

  /** @param {number | null} x the place to mark */
  mark(x) {
    if (x === this.#mark) return;
    this.#mark = x;
    this.#draw();
  }

  /** @returns {Size} */
  get #size() {
    this.#measured ??= this.#measure();
    return this.#measured;
  }

  /** @returns {Size} */
  #measure() {
    // The text scales with the page's text size.
    const font = 0.75 * parseFloat(getComputedStyle(document.documentElement).fontSize);
    const { left, right, top, bottom } = MARGIN;
    const margin = { left: left * font, right: right * font, top: top * font, bottom: bottom * font };
    return { width: this.canvas.clientWidth, height: this.canvas.clientHeight, font, margin };
  }

  /** Paints the whole plot. */
  #paint() {
    const size = this.#size;
    if (!this.#plot || size.width === 0) return;
    const density = window.devicePixelRatio || 1;
    this.#still ??= sheetContext(Math.round(size.width * density), Math.round(size.height * density));
    const ctx = this.#still;
    ctx.setTransform(density, 0, 0, density, 0, 0);
    ctx.clearRect(0, 0, size.width, size.height);
    const sheet = { ctx, palette: this.theme.palette, ...size, ...scales(size, this.#plot) };
    const { series, events = [], limit } = this.#plot;
    paintAxes(sheet, this.#plot);
    for (const curve of series) paintSeries(sheet, curve);
    ctx.fillStyle = sheet.palette.flash; // a tick on the axis for each event
    for (const place of events) {
      ctx.fillRect(sheet.px(place) - 0.75, size.height - size.margin.bottom - 7, 1.5, 7);
    }
    if (limit) paintLimit(sheet, limit);
    this.#draw();
  }

  #draw() {
    if (!this.#plot || !this.#still) return;
    const { width, height, margin: { top, bottom } } = this.#size;
    const ctx = fitted(this.canvas, { width, height });
    ctx.drawImage(this.#still.canvas, 0, 0, width, height);
    if (this.#mark === null) return;
    const { from, to } = this.#plot.x;
    const x = scales(this.#size, this.#plot).px(Math.min(to, Math.max(from, this.#mark)));
    ctx.fillStyle = this.theme.palette.trayMark;
    ctx.fillRect(x - 1, top, 2, height - top - bottom);
  }

  /** @param {(x: number) => void} onPick */
  #followPointer(onPick) {
    /** @param {PointerEvent} event */
    const pick = (event) => {
      if (!this.#plot) return;
      const box = this.canvas.getBoundingClientRect();
      const { from, to } = this.#plot.x;
      const x = scales(this.#size, this.#plot).x(event.clientX - box.left);
      onPick(Math.min(to, Math.max(from, x)));
    };
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      pick(event);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (this.canvas.hasPointerCapture(event.pointerId)) pick(event);
    });
  }
}

/** @param {Size} size @param {Plot} plot @returns {Scales} conversions between values and CSS pixels */
function scales({ width, height, margin }, { x, y }) {
  const [left, right] = [margin.left, width - margin.right];
  const [top, bottom] = [margin.top, height - margin.bottom];
  /** @param {number} value */
  const raw = (value) => (y.log ? Math.log10(value) : value);
  const rise = raw(y.to) - raw(y.from) || 1;
  /** @param {number} value */
  const along = (value) => (x.log ? Math.log10(value) : value);
  const run = along(x.to) - along(x.from) || 1;
  /** @param {number} value */
  const within = (value) => Math.min(1.02, Math.max(0, value));
  return {
    px: (value) => left + ((along(value) - along(x.from)) / run) * (right - left),
    py: (value) =>
      bottom - within((raw(Math.max(value, y.log ? y.from : value)) - raw(y.from)) / rise) * (bottom - top),
    x: (px) => x.from + ((px - left) / (right - left)) * run, // picked only on axes that are not logarithmic
  };
}

/** @param {Sheet} sheet @param {Plot} plot */
function paintAxes({ ctx, width, height, font, margin, px, py, palette }, { x, y }) {
  ctx.font = `500 ${font}px ${FAMILY}`;
  ctx.fillStyle = palette.trayInk;
  ctx.textBaseline = "middle";
  ctx.textAlign = "right";
  const rows = Math.max(2, Math.floor(height / (2.5 * font)));
  const levels = y.log ? powerTicks(y.from, y.to, rows) : ticks(y.from, y.to, rows);
  for (const level of levels) {
    ctx.globalAlpha = 0.25;
    ctx.fillRect(margin.left, py(level) - 0.5, width - margin.left - margin.right, 1);
    ctx.globalAlpha = 1;
    ctx.fillText(y.log ? powerText(level) : figure(level), margin.left - 0.5 * font, py(level));
  }
  ctx.textBaseline = "alphabetic";
  ctx.textAlign = "center";
  const columns = Math.max(2, Math.floor(width / (6.5 * font)));
  const bottom = height - margin.bottom;
  const room = width - margin.right - ctx.measureText(x.unit).width - font;
  for (const place of x.log ? powerTicks(x.from, x.to, columns) : ticks(x.from, x.to, columns)) {
    ctx.fillRect(px(place) - 0.5, bottom, 1, 4);
    if (px(place) < room) ctx.fillText(x.log ? powerText(place) : figure(place), px(place), height - 0.5 * font);
  }
  ctx.textAlign = "right";
  ctx.fillText(x.unit, width - margin.right, height - 0.5 * font);
  // Above all levels, where no curve is.
  ctx.fillText(y.unit, margin.left - 0.5 * font, margin.top - 0.7 * font);
}

/** @param {Sheet} sheet @param {Curve} curve */
function paintSeries({ ctx, px, py, palette }, { points, base, colour, width = 2, alpha = 1, dots }) {
  ctx.globalAlpha = alpha;
  ctx.beginPath();
  for (const { x, y } of points) ctx.lineTo(px(x), py(y));
  if (base) {
    for (let i = base.length - 1; i >= 0; i -= 1) ctx.lineTo(px(base[i].x), py(base[i].y));
    ctx.fillStyle = palette[colour];
    ctx.fill();
  } else {
    ctx.strokeStyle = palette[colour];
    ctx.lineWidth = width;
    ctx.lineJoin = "round";
    ctx.stroke();
  }
  if (dots || points.length === 1) {
    ctx.fillStyle = palette[colour];
    for (const { x, y } of points) disc(ctx, px(x), py(y), 3);
  }
  ctx.globalAlpha = 1;
}

/** @param {Sheet} sheet @param {Limit} limit */
function paintLimit({ ctx, width, height, font, margin, py, palette }, { y, text }) {
  ctx.save();
  ctx.strokeStyle = palette.ballLight;
  ctx.lineWidth = 1.5;
  ctx.setLineDash([6, 4]);
  strokeLine(ctx, margin.left, py(y), width - margin.right, py(y));
  ctx.restore();
  // On a low plot the text would cover curves and events. The page contains it too.
  if (height - margin.top - margin.bottom < LIMIT_LINES * font) return;
  ctx.fillStyle = palette.trayInk;
  ctx.textAlign = "right";
  ctx.fillText(text, width - margin.right, py(y) + 1.1 * font);
}
