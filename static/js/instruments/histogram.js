// The tray under the bins: how many balls lie in each, beside how many theory expects.

import { counted } from "../util/format.js";

const TOP = 12; // CSS pixels kept free above the highest column
const WORDS_MS = 700;
const BEAD = 4; // CSS pixels: from this size on, single balls are told apart

/** Draws counts on a canvas whose columns stand under the board's bins. */
export class Histogram {
  #counts = [];
  #expected = null;
  #geometry = null;
  #height = 0;
  #stale = true;
  #told = 0;

  /** @param {HTMLCanvasElement} canvas @param {import("../paint/theme.js").Theme} theme */
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
    this.setExpected(expected);
  }

  /** @param {{label: string, chances: number[]} | null} expected */
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

  /** Draws what was added since; many balls of one frame are drawn once. */
  refresh(nowMs) {
    if (!this.#stale && this.#told === this.total) return;
    if (this.#stale) this.#paint();
    // Words are for those who listen: they are not told sixty times a second.
    if (nowMs - this.#toldMs >= WORDS_MS) this.#tell(nowMs);
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

  /** @param {import("../paint/geometry.js").Geometry} geometry the board's, whose columns are shared */
  layOut(geometry) {
    this.#geometry = geometry;
    this.#height = this.canvas.parentElement.clientHeight;
    this.draw();
  }

  /** Draws and says it all at once. */
  draw() {
    if (!this.board || !this.#geometry) return;
    this.#paint();
    this.#tell(performance.now());
  }

  #paint() {
    this.#stale = false;
    if (!this.board || !this.#geometry) return;
    const height = this.#height;
    const ctx = this.#fit(this.#geometry.width, height);
    const { total } = this;
    const expected = this.#expected?.chances.map((chance) => chance * Math.max(total, 1));
    const most = Math.max(1, ...this.#counts, ...(expected ?? []));
    const unit = (height - TOP) / Math.max(most, total ? 4 : 0.5);
    this.#paintBars(ctx, height, unit);
    if (expected) this.#paintExpected(ctx, height, unit, expected);
  }

  /** A canvas is made anew only when its size has changed: that is dear. */
  #fit(width, height) {
    const density = window.devicePixelRatio || 1;
    const across = Math.round(width * density);
    const down = Math.round(height * density);
    const ctx = this.canvas.getContext("2d");
    if (this.canvas.width !== across || this.canvas.height !== down) {
      this.canvas.width = across;
      this.canvas.height = down;
    }
    ctx.setTransform(density, 0, 0, density, 0, 0);
    ctx.clearRect(0, 0, width, height);
    return ctx;
  }

  #tell(nowMs) {
    this.#told = this.total;
    this.#toldMs = nowMs;
    this.canvas.setAttribute("aria-label", this.describe(this.#told));
  }

  #toldMs = 0;

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
