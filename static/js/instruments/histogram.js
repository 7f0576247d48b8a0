// The tray under the bins: how many balls lie in each, beside how many theory expects.

import { t } from "../texts/text.js";
import { fitted } from "../util/canvas.js";
import { parentOf } from "../util/dom.js";

/** @import { Bins, Board } from "../model/board.js" */
/** @import { Geometry } from "../paint/geometry.js" */
/** @import { Theme } from "../paint/theme.js" */

const TOP = 12; // CSS pixels kept free above the highest column
const TOLD_MS = 700; // between two descriptions
const BEAD = 4; // CSS pixels: from this size on, single balls are told apart

/** @typedef {{label: string, chances: number[]}} Expectation how often each bin should be hit */

/** Draws counts on a canvas whose columns stand under the board's bins. */
export class Histogram {
  /** @type {number[]} */
  #counts = [];
  /** @type {Expectation | null} */
  #expected = null;
  /** @type {Geometry | null} */
  #geometry = null;
  /** @type {Bins} */
  #bins = { y: 0, edges: [], multipliers: [] };
  #height = 0;
  #stale = true;
  #told = 0;
  #toldMs = 0;

  /** @param {HTMLCanvasElement} canvas @param {Theme} theme */
  constructor(canvas, theme) {
    this.canvas = canvas;
    this.theme = theme;
  }

  /**
   * @param {Board} board
   * @param {number[]} counts per bin
   * @param {Expectation | null} expected
   */
  setBoard(board, counts, expected) {
    this.#bins = board.bins;
    this.#counts = [...counts];
    this.setExpected(expected);
  }

  /** @param {Expectation | null} expected */
  setExpected(expected) {
    this.#expected = expected;
    this.#told = 0;
    this.draw();
  }

  get counts() {
    return this.#counts;
  }

  /** @param {number} bin one more ball lies here */
  add(bin) {
    this.#counts[bin] += 1;
    this.#stale = true;
  }

  /** Draws what was added since; many balls of one picture are drawn once. @param {number} nowMs */
  refresh(nowMs) {
    if (!this.#stale && this.#told === this.total) return;
    if (this.#stale) this.#paint();
    // The description is for those who listen: it is not told sixty times a second.
    if (nowMs - this.#toldMs >= TOLD_MS) this.#tell(nowMs);
  }

  /** Something is left to draw or to say. */
  get pending() {
    return this.#stale || this.#told !== this.total;
  }

  get total() {
    let total = 0;
    for (const count of this.#counts) total += count;
    return total;
  }

  /** @param {Geometry} geometry the board's, whose columns are shared */
  layOut(geometry) {
    this.#geometry = geometry;
    this.#height = parentOf(this.canvas).clientHeight;
    this.draw();
  }

  /** Draws and says it all at once. */
  draw() {
    if (!this.#geometry) return;
    this.#paint();
    this.#tell(performance.now());
  }

  #paint() {
    this.#stale = false;
    const geometry = this.#geometry;
    if (!geometry) return;
    const height = this.#height;
    const ctx = fitted(this.canvas, { width: geometry.width, height });
    const { total } = this;
    const expected = this.#expected?.chances.map((chance) => chance * Math.max(total, 1));
    const most = Math.max(1, ...this.#counts, ...(expected ?? []));
    const unit = (height - TOP) / Math.max(most, total ? 4 : 0.5);
    this.#paintBars(ctx, geometry, height, unit);
    if (expected) this.#paintExpected(ctx, geometry, height, unit, expected);
  }

  /** @param {number} nowMs */
  #tell(nowMs) {
    this.#told = this.total;
    this.#toldMs = nowMs;
    this.canvas.setAttribute("aria-label", this.describe(this.#told));
  }

  /** @param {number} total @returns {string} the alternative text */
  describe(total) {
    if (total === 0) return t("lab.histogram-none");
    const bins = this.#counts.map((count, bin) => ({ count, bin })).filter(({ count }) => count);
    const parts = bins.map(({ count, bin }) => t("lab.histogram-bin", { bin, count }));
    return t("lab.histogram", { n: total, bins: parts.join(", ") });
  }

  /** @param {number} bin @param {Geometry} geometry @returns {{x: number, width: number}} CSS pixels */
  #column(bin, { px }) {
    const { edges } = this.#bins;
    const from = px(edges[bin]);
    const width = px(edges[bin + 1]) - from;
    const gap = Math.max(1, Math.min(3, 0.06 * width));
    return { x: from + gap, width: width - 2 * gap };
  }

  /**
   * @param {CanvasRenderingContext2D} ctx
   * @param {Geometry} geometry
   * @param {number} height
   * @param {number} unit
   */
  #paintBars(ctx, geometry, height, unit) {
    this.#counts.forEach((count, bin) => {
      const { x, width } = this.#column(bin, geometry);
      ctx.fillStyle = this.theme.payout(this.#bins.multipliers[bin]).fill;
      if (unit < BEAD) {
        ctx.fillRect(x, height - count * unit, width, count * unit);
        return;
      }
      for (let ball = 1; ball <= count; ball += 1) {
        ctx.fillRect(x, height - ball * unit + 1, width, unit - 1);
      }
    });
  }

  /**
   * @param {CanvasRenderingContext2D} ctx
   * @param {Geometry} geometry
   * @param {number} height
   * @param {number} unit
   * @param {number[]} expected
   */
  #paintExpected(ctx, geometry, height, unit, expected) {
    ctx.strokeStyle = this.theme.palette.trayMark;
    ctx.lineWidth = 2;
    ctx.lineCap = "round";
    ctx.beginPath();
    expected.forEach((count, bin) => {
      const { x, width } = this.#column(bin, geometry);
      const y = Math.min(height - 1, height - count * unit);
      ctx.moveTo(x + 1, y);
      ctx.lineTo(x + width - 1, y);
    });
    ctx.stroke();
  }
}
