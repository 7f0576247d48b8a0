// Ghost trails: the layer that balls paint as they pass, and with it the distribution.

import { sides } from "../../paint/geometry.js";
import { contextOf } from "../../util/canvas.js";
import { Density } from "./density.js";

/** @import { Board } from "../../model/board.js" */
/** @import { Geometry } from "../../paint/geometry.js" */
/** @import { Palette, Theme } from "../../paint/theme.js" */
/** @import { Field } from "./density.js" */
/** @import { Keyframe, Law } from "../../model/motion/interpolate.js" */

const TONES = 256;
const ROWS_A_FRAME = 48; // of pixels painted at once: a fraction of a millisecond
const PAUSE_MS = 120; // between two sweeps over what has changed
const STRONGEST = 0.62; // opacity
const FULL = 60; // a cell this full is painted solid, until another has more

/**
 * @typedef {{density: Density, band: ImageData, picture: HTMLCanvasElement}} Grid band: some rows of it as pixels;
 *   picture: all of it, a pixel a cell
 */

/**
 * Paints a density onto its own canvas, a band of rows at a time. The canvas has the display's pixels: cells that
 * are stretched over the board are stretched when they change, and not for each frame.
 */
export class Ghost {
  #on = true;
  /** Of the board, once there is one. @type {Field | null} */
  #field = null;
  /** @type {Grid | null} */
  #grid = null;
  #next = 0; // row to go on with in this sweep
  #until = -1; // last row of this sweep
  #sweptMs = 0;
  #range = 0; // `most` that the picture on the canvas was made for

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

  /** Off, it neither counts nor paints. */
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
   * A stretch of a path that a ball has left behind; see Path.forget.
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

  /** The colours have changed: all is painted anew. */
  recolour() {
    this.tones = tonesOf(this.theme.palette);
    if (!this.#grid) return;
    const { density } = this.#grid;
    density.firstRow = 0;
    density.lastRow = density.height - 1;
  }

  /** Something is left to paint. */
  get pending() {
    return this.#on && (this.#until >= 0 || (this.#grid?.density.lastRow ?? -1) >= 0);
  }

  /**
   * Paints a little, if there is something to paint and the last sweep is long enough ago.
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
    // A new maximum tones everything down, so everything is painted anew; but not for each ball.
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
    // A logarithm, so that the first ball is seen and the thousandth too.
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
    // Between two rows their colours run into each other, so the neighbours' halves change, too.
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
 * @returns {Uint32Array} ABGR by tone: from the board's own light to the glow of a flash
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
