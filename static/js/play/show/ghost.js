// Ghost trails: a layer that shows where balls have passed, and so their distribution.

import { sides } from "../../paint/geometry.js";
import { contextOf } from "../../util/canvas.js";
import { Density } from "./density.js";

/** @import { Board } from "../../model/board.js" */
/** @import { Geometry } from "../../paint/geometry.js" */
/** @import { Palette, Theme } from "../../paint/theme.js" */
/** @import { Field } from "./density.js" */
/** @import { Keyframe, Law } from "../../model/motion/interpolate.js" */

const TONES = 256;
const ROWS_A_FRAME = 48; // rows of cells painted a frame, in a fraction of a millisecond
const PAUSE_MS = 120; // between two sweeps over the changed rows
const STRONGEST = 0.62; // opacity
const FULL = 60; // count of a cell with the strongest tone, until a cell has more

/**
 * @typedef {{density: Density, band: ImageData, picture: HTMLCanvasElement}} Grid band: some rows as pixels;
 *   picture: the whole grid, one pixel per cell
 */

/**
 * Paints a density onto its own canvas, a band of rows at a time. The canvas has the display's resolution, so that
 * the browser scales cells only when they change, not in each frame.
 */
export class Ghost {
  #on = true;
  /** @type {Field | null} */
  #field = null;
  /** @type {Grid | null} */
  #grid = null;
  #next = 0; // next row of this sweep
  #until = -1; // last row of this sweep
  #sweptMs = 0;
  #range = 0; // the density's `most` at the last full sweep

  /** @param {HTMLCanvasElement} canvas @param {Theme} theme */
  constructor(canvas, theme) {
    this.canvas = canvas;
    this.theme = theme;
    this.follow = this.follow.bind(this);
    this.tones = tonesOf(theme.palette);
  }

  get on() {
    return this.#on;
  }

  /** When off, it neither counts nor paints. */
  set on(on) {
    this.#on = on;
    this.canvas.hidden = !on;
    if (!on) this.clear();
  }

  /** @param {Board} board */
  setBoard(board) {
    this.#field = { ...sides(board), top: board.drop.y - board.ball.radius, bottom: board.bins.y };
    this.clear();
  }

  /** @param {Geometry} geometry where the board lies now */
  layOut({ py, scale, width }) {
    if (!this.#grid) return;
    const { field, height } = this.#grid.density;
    const { canvas } = this;
    const sharp = window.devicePixelRatio || 1;
    canvas.width = Math.round(width * sharp);
    canvas.height = Math.round((field.bottom - field.top) * scale * sharp);
    Object.assign(canvas.style, {
      top: `${Math.round(py(field.top) * sharp) / sharp}px`,
      width: `${canvas.width / sharp}px`,
      height: `${canvas.height / sharp}px`,
    });
    this.#stretch(this.#grid, 0, height);
  }

  /**
   * Adds a part of a path that a ball has completed; see Path.forget.
   * @param {Keyframe} a
   * @param {Keyframe} b
   * @param {Law} law
   */
  follow(a, b, law) {
    if (this.#on) this.#grid?.density.follow(a, b, law);
  }

  clear() {
    this.#range = 0;
    this.#until = -1;
    contextOf(this.canvas).clearRect(0, 0, this.canvas.width, this.canvas.height);
    if (!this.#field) return;
    const density = new Density(this.#field);
    const { width, height } = density;
    const picture = Object.assign(document.createElement("canvas"), { width, height });
    this.#grid = { density, band: new ImageData(width, ROWS_A_FRAME), picture };
  }

  /** Repaints everything in the theme's new colours. */
  recolour() {
    this.tones = tonesOf(this.theme.palette);
    if (!this.#grid) return;
    const { density } = this.#grid;
    density.firstRow = 0;
    density.lastRow = density.height - 1;
  }

  /** Whether something is left to paint. */
  get pending() {
    return this.#on && (this.#until >= 0 || (this.#grid?.density.lastRow ?? -1) >= 0);
  }

  /**
   * Paints the next band of rows, if rows have changed and the last sweep is long enough ago.
   * @param {number} nowMs
   */
  paint(nowMs) {
    if (!this.#on || !this.#grid) return;
    if (this.#until < 0 && !this.#begin(this.#grid.density, nowMs)) return;
    const rows = Math.min(ROWS_A_FRAME, this.#until - this.#next + 1);
    this.#paintRows(this.#grid, this.#next, rows);
    this.#next += rows;
    if (this.#next > this.#until) {
      this.#until = -1;
      this.#sweptMs = nowMs;
    }
  }

  /** @param {Density} density @param {number} nowMs */
  #begin(density, nowMs) {
    if (density.lastRow < 0 || nowMs - this.#sweptMs < PAUSE_MS) return false;
    // A new maximum dims every cell, which needs a full repaint: it waits until the maximum has grown by a quarter.
    const all = density.most > 1.25 * this.#range;
    if (all) this.#range = density.most;
    this.#next = all ? 0 : density.firstRow;
    this.#until = all ? density.height - 1 : density.lastRow;
    density.firstRow = density.height;
    density.lastRow = -1;
    return true;
  }

  /** @param {Grid} grid @param {number} first @param {number} rows */
  #paintRows(grid, first, rows) {
    const { density: { cells, width, most }, band, picture } = grid;
    const pixels = new Uint32Array(band.data.buffer);
    const from = first * width;
    // The scale is logarithmic, so that both the first and the thousandth ball are visible.
    const scale = (TONES - 1) / Math.log1p(Math.max(FULL, most));
    for (let i = 0; i < rows * width; i += 1) {
      const cell = cells[from + i];
      pixels[i] = this.tones[cell > 0 ? Math.min(TONES - 1, Math.round(scale * Math.log1p(cell))) : 0];
    }
    contextOf(picture).putImageData(band, 0, first, 0, 0, width, rows);
    this.#stretch(grid, first, rows);
  }

  /** @param {Grid} grid @param {number} first @param {number} rows that have changed */
  #stretch({ density, picture }, first, rows) {
    const { width, height } = this.canvas;
    const ctx = contextOf(this.canvas);
    // Scaling blends neighbouring rows, so half a row above and below changes too.
    const from = Math.floor(((first - 0.5) * height) / density.height);
    const to = Math.ceil(((first + rows + 0.5) * height) / density.height);
    ctx.save();
    ctx.beginPath();
    ctx.rect(0, from, width, to - from);
    ctx.clip();
    ctx.clearRect(0, 0, width, height);
    ctx.drawImage(picture, 0, 0, width, height);
    ctx.restore();
  }
}

/**
 * @param {Palette} palette
 * @returns {Uint32Array} ABGR by tone, from the colour of the light on the board to that of a flash
 */
function tonesOf({ ray, trayBar, flash }) {
  const stops = [ray, trayBar, flash].map((hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16)));
  return Uint32Array.from({ length: TONES }, (_, tone) => {
    const s = (tone / (TONES - 1)) * (stops.length - 1);
    const from = Math.min(stops.length - 2, Math.floor(s));
    const [r, g, b] = stops[from].map((value, part) =>
      Math.round(value + (s - from) * (stops[from + 1][part] - value)));
    const alpha = Math.round(255 * STRONGEST * Math.min(1, (tone / (TONES - 1)) * 1.3));
    return ((alpha << 24) | (b << 16) | (g << 8) | r) >>> 0;
  });
}
