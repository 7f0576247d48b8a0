// The histogram in the tray under the bins: landings in each bin, and the expected numbers. In a wide tray the columns fan
// out to its sides, as the pile's do.

import { t } from "../texts/text.js";
import { fitted } from "../util/canvas.js";
import { parentOf } from "../util/dom.js";
import { spreadOut, trayGeometry } from "./pile/columns.js";

/** @import { Board } from "../model/board.js" */
/** @import { Geometry } from "../paint/geometry.js" */
/** @import { Theme } from "../paint/theme.js" */
/** @import { Colours } from "./colours.js" */
/** @import { Entry, TrayGeometry } from "./pile/columns.js" */
/** @import { Pile } from "./pile/pile.js" */

const TOP = 12; // CSS pixels free above the highest column
const TOLD_MS = 700; // between two updates of the alternative text
const BEAD = 4; // CSS pixels: from this height on, each ball is drawn separately

/** @typedef {{label: string, chances: number[]}} Expectation chances: probability of each bin */

/** Draws counts on a canvas, in columns under the board's bins. */
export class Histogram {
  /** By bin. @type {number[]} */
  counts = [];
  /** @type {Expectation | null} */
  expected = null;
  /** Of the board above. @type {Geometry | null} */
  #above = null;
  /** @type {TrayGeometry | null} */
  #geometry = null;
  /** @type {Board | null} */
  #board = null;
  /** Drawn instead of bars. @type {Pile | null} */
  #pile = null;
  #height = 0;
  #stale = true;
  #told = 0;
  #toldMs = 0;

  /**
   * @param {HTMLCanvasElement} canvas @param {Theme} theme
   * @param {Colours | null} colours of the balls; without them each bin has the colour of its payout
   */
  constructor(canvas, theme, colours = null) {
    this.canvas = canvas;
    this.theme = theme;
    this.colours = colours;
    new ResizeObserver(() => {
      if (this.#geometry && parentOf(canvas).clientWidth !== this.#geometry.width) this.#layOut();
    }).observe(parentOf(canvas));
  }

  /**
   * @param {Board} board
   * @param {number[]} counts per bin
   * @param {Expectation | null} expected
   */
  setBoard(board, counts, expected) {
    this.#board = board;
    this.counts = [...counts];
    this.colours?.fit(counts);
    this.expected = expected;
    this.#layOut();
  }

  /** @param {Expectation | null} expected */
  setExpected(expected) {
    this.expected = expected;
    this.#told = 0;
    this.draw();
  }

  /** @param {Pile | null} pile to draw from now on; null for bars */
  setPile(pile) {
    this.#pile = pile;
    this.#heapUp();
    this.draw();
  }

  #heapUp() {
    if (this.#board && this.#geometry) {
      this.#pile?.lay(this.#board, this.#geometry, this.#height, this.counts);
    }
  }

  /** @returns {number | null} how many balls a disc of the pile represents; null for bars */
  get share() {
    return this.#pile?.share ?? null;
  }

  /**
   * Adds a ball to a bin.
   * @param {number} bin @param {Entry | null} entry where and how fast it landed, if known @param {string} [colour] its own
   */
  add(bin, entry, colour) {
    this.counts[bin] += 1;
    this.colours?.add(bin, colour ?? null);
    this.#pile?.update(this.counts, entry);
    this.#stale = true;
  }

  /**
   * Draws changes since the last frame, however many balls landed in it.
   * @param {number} nowMs @param {boolean} still whether the visitor prefers reduced motion
   */
  refresh(nowMs, still) {
    if (this.#pile?.advance(nowMs, still)) this.#stale = true;
    if (!this.#stale && this.#told === this.total) return;
    if (this.#stale) this.#paint();
    // Screen readers read the alternative text aloud, so it must not change sixty times a second.
    if (nowMs - this.#toldMs >= TOLD_MS) this.#tell(nowMs);
  }

  /** @returns {string} the visible sentence: how many balls landed */
  get words() {
    const [n, share] = [this.total, this.share ?? 1];
    if (n === 0) return t("play.none-landed");
    return t(share > 1 ? "play.landed-as-discs" : "play.landed-here", { n, share });
  }

  /** Whether something is left to draw, or the alternative text is out of date. */
  get pending() {
    return this.#stale || this.#told !== this.total || (this.#pile?.runs ?? false);
  }

  get total() {
    let total = 0;
    for (const count of this.counts) total += count;
    return total;
  }

  /** @param {Geometry} geometry of the board above */
  layOut(geometry) {
    this.#above = geometry;
    this.#layOut();
  }

  #layOut() {
    if (!this.#above || !this.#board) return;
    const { clientWidth, clientHeight } = parentOf(this.canvas);
    this.#geometry = trayGeometry(this.#board, this.#above, clientWidth);
    this.#height = clientHeight;
    this.#heapUp();
    this.draw();
  }

  /** Draws everything, and updates the alternative text immediately. */
  draw() {
    if (!this.#geometry) return;
    this.#paint();
    this.#tell(performance.now());
  }

  #paint() {
    this.#stale = false;
    const [geometry, board, height] = [this.#geometry, this.#board, this.#height];
    if (!geometry || !board) return;
    const ctx = fitted(this.canvas, { width: geometry.width, height });
    const { total } = this;
    const pile = this.#pile;
    const columnAt = columnsOf(board, geometry, height);
    const expected = this.expected?.chances.map((chance) => chance * Math.max(total, pile ? 0 : 1));
    const most = Math.max(1, ...this.counts, ...(expected ?? []));
    const unit = (height - TOP) / Math.max(most, total ? 4 : 0.5);
    if (pile) pile.paint(ctx, board, geometry, height, (bin, ball) => this.#colourOf(board, bin, ball));
    else this.#paintBars({ ctx, columnAt, height }, board, unit);
    const heights = expected?.map((count, bin) => (pile ? pile.heightOf(bin, count, geometry) : count * unit));
    if (heights) this.#paintExpected({ ctx, columnAt, height }, heights);
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
    const bins = this.counts.map((count, bin) => ({ count, bin })).filter(({ count }) => count);
    const parts = bins.map(({ count, bin }) => t("lab.histogram-bin", { bin, count }));
    return t("lab.histogram", { n: total, bins: parts.join(", ") });
  }

  /** @param {Board} board @param {number} bin @param {number} ball from 0 at the bottom @returns {string} */
  #colourOf({ bins: { multipliers } }, bin, ball) {
    if (!this.colours) return this.theme.payout(multipliers[bin]).fill;
    return this.colours.of(bin, ball) ?? this.theme.palette.other;
  }

  /** @param {Sheet} sheet @param {Board} board @param {number} unit of a ball, CSS pixels */
  #paintBars({ ctx, columnAt, height }, board, unit) {
    /** @param {number} bin @param {number} top @param {number} bottom CSS pixels */
    const block = (bin, top, bottom) => {
      const [high, low] = [columnAt(bin, top), columnAt(bin, bottom)];
      ctx.beginPath();
      ctx.moveTo(high.x, top);
      ctx.lineTo(high.x + high.width, top);
      ctx.lineTo(low.x + low.width, bottom);
      ctx.lineTo(low.x, bottom);
      ctx.fill();
    };
    this.counts.forEach((count, bin) => {
      if (unit >= BEAD) {
        for (let ball = 0; ball < count; ball += 1) {
          ctx.fillStyle = this.#colourOf(board, bin, ball);
          block(bin, height - (ball + 1) * unit + 1, height - ball * unit);
        }
        return;
      }
      // Single balls are too small to draw: one block for each colour.
      let low = height;
      for (const { colour, balls } of this.colours?.sharesOf(bin) ?? [{ colour: null, balls: count }]) {
        const high = balls * unit;
        ctx.fillStyle = this.colours ? colour ?? this.theme.palette.other : this.#colourOf(board, bin, 0);
        block(bin, low - high, low);
        low -= high;
      }
    });
  }

  /** @param {Sheet} sheet @param {number[]} heights of the expected numbers, CSS pixels */
  #paintExpected({ ctx, columnAt, height }, heights) {
    ctx.strokeStyle = this.theme.palette.trayMark;
    ctx.lineWidth = Math.max(2, height / 100);
    ctx.lineCap = "round";
    ctx.beginPath();
    heights.forEach((high, bin) => {
      const y = Math.max(1, Math.min(height - 1, height - high));
      const { x, width } = columnAt(bin, y);
      ctx.moveTo(x + 1, y);
      ctx.lineTo(x + width - 1, y);
    });
    ctx.stroke();
  }
}

/**
 * @typedef {(bin: number, y: number) => {x: number, width: number}} ColumnAt a column at a height of the canvas, CSS pixels
 * @typedef {{ctx: CanvasRenderingContext2D, columnAt: ColumnAt, height: number}} Sheet height: CSS pixels
 */

/** @param {Board} board @param {TrayGeometry} geometry @param {number} height of the tray, CSS pixels @returns {ColumnAt} */
function columnsOf({ bins: { edges } }, { px, spread }, height) {
  const floors = spreadOut(edges, spread);
  return (bin, y) => {
    const [from, to] = [bin, bin + 1].map((i) => px(edges[i] + (floors[i] - edges[i]) * (y / height)));
    const gap = Math.max(1, Math.min(3, 0.06 * (to - from)));
    return { x: from + gap, width: to - from - 2 * gap };
  };
}
