// The tray under the bins: how many balls lie in each, beside how many theory expects.

import { counted } from "./format.js";

const TOP = 12; // CSS pixels kept free above the highest column
const BEAD = 4; // CSS pixels: from this size on, single balls are told apart

/** Draws counts on a canvas whose columns stand under the board's bins. */
export class Histogram {
  #counts = [];
  #expected = null;
  #geometry = null;

  /** @param {HTMLCanvasElement} canvas @param {import("./theme.js").Theme} theme */
  constructor(canvas, theme) {
    this.canvas = canvas;
    this.theme = theme;
  }

  /**
   * @param {any} board
   * @param {number[]} counts per bin
   * @param {{label: string, chances: number[]} | null} expected
   */
  setBoard(board, counts, expected) {
    this.board = board;
    this.#counts = [...counts];
    this.#expected = expected;
    this.draw();
  }

  get counts() {
    return this.#counts;
  }

  /** @param {number} bin one more ball lies here */
  add(bin) {
    this.#counts[bin] += 1;
    this.draw();
  }

  /** @param {import("./geometry.js").Geometry} geometry the board's, whose columns are shared */
  layOut(geometry) {
    this.#geometry = geometry;
    this.draw();
  }

  draw() {
    if (!this.board || !this.#geometry) return;
    const { width } = this.#geometry;
    const height = this.canvas.parentElement.clientHeight;
    const density = window.devicePixelRatio || 1;
    this.canvas.width = Math.round(width * density);
    this.canvas.height = Math.round(height * density);
    const ctx = this.canvas.getContext("2d");
    ctx.setTransform(density, 0, 0, density, 0, 0);
    const total = this.#counts.reduce((sum, count) => sum + count, 0);
    const expected = this.#expected?.chances.map((chance) => chance * Math.max(total, 1));
    const most = Math.max(1, ...this.#counts, ...(expected ?? []));
    const unit = (height - TOP) / Math.max(most, total ? 4 : 0.5);
    this.#paintBars(ctx, height, unit);
    if (expected) this.#paintExpected(ctx, height, unit, expected);
    this.canvas.setAttribute("aria-label", this.describe(total));
  }

  /** @param {number} total @returns {string} the picture in words */
  describe(total) {
    if (total === 0) return "Histogram: nothing has landed at this table yet.";
    const bins = this.#counts.map((count, bin) => ({ count, bin })).filter(({ count }) => count);
    const parts = bins.map(({ count, bin }) => `bin ${bin}: ${count}`);
    return `Histogram of ${counted(total, "drop")} at this table. ${parts.join(", ")}.`;
  }

  #column(bin) {
    const { px } = this.#geometry;
    const { edges } = this.board.bins;
    const from = px(edges[bin]);
    const width = px(edges[bin + 1]) - from;
    const gap = Math.max(1, Math.min(3, 0.06 * width));
    return { x: from + gap, width: width - 2 * gap };
  }

  #paintBars(ctx, height, unit) {
    this.#counts.forEach((count, bin) => {
      const { x, width } = this.#column(bin);
      ctx.fillStyle = this.theme.payout(this.board.bins.multipliers[bin]).fill;
      if (unit < BEAD) {
        ctx.fillRect(x, height - count * unit, width, count * unit);
        return;
      }
      for (let ball = 1; ball <= count; ball += 1) {
        ctx.fillRect(x, height - ball * unit + 1, width, unit - 1);
      }
    });
  }

  #paintExpected(ctx, height, unit, expected) {
    ctx.strokeStyle = this.theme.palette.trayMark;
    ctx.lineWidth = 2;
    ctx.lineCap = "round";
    ctx.beginPath();
    expected.forEach((count, bin) => {
      const { x, width } = this.#column(bin);
      const y = Math.min(height - 1, height - count * unit);
      ctx.moveTo(x + 1, y);
      ctx.lineTo(x + width - 1, y);
    });
    ctx.stroke();
  }
}
