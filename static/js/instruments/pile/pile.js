// The pile in the tray: landed balls as discs that fall, roll and come to rest. A disc represents one ball or more.

import { paintBall } from "../../paint/ball.js";
import { StampBook } from "../../paint/stamps.js";
import { discsOf, planOf, shareFor, SMALL_DISCS, spreadOut, usualEntry } from "./columns.js";
import { openHeaps } from "./heap.js";

/** @import { Board } from "../../model/board.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Entry, Plan, Sizes, TrayGeometry } from "./columns.js" */
/** @import { Disc, Heap } from "./heap.js" */

const MOST_STEPS = 4; // in one frame: on a slow machine discs fall slowly instead of delaying the board
const AHEAD_STEPS = 8; // in one frame, while the motion is not shown
const DENSE = 0.8; // fraction of a column's area that well packed discs fill

/**
 * Loads the kernels that move discs, and makes a pile; throws without WebAssembly.
 * @param {Theme} theme @param {Sizes} [sizes] of its discs
 * @returns {Promise<Pile>}
 */
export async function openPile(theme, sizes = SMALL_DISCS) {
  return new Pile(await openHeaps(), theme, sizes);
}

/** The pile of one tray. While all discs are at rest, nothing is computed or drawn. */
export class Pile {
  /** How many balls a disc represents. */
  share = 1;
  /** @type {Heap | null} null until `lay` */
  #heap = null;
  /** @type {Plan | null} */
  #plan = null;
  /** @type {number[]} */
  #counts = [];
  /** Number of discs by column, including those that have not entered yet. @type {number[]} */
  #discs = [];
  /** @type {Disc[]} */
  #shown = [];
  /** Time of the last step, ms; 0 while nothing moves. */
  #clock = 0;
  /** Whether to compute until all discs are at rest without showing their motion. */
  #ahead = false;
  /** @type {StampBook | null} */
  #stamps = null;

  /**
   * @param {{heapFor: (plan: Plan) => Heap, stepMs: number}} heaps @param {Theme} theme
   * @param {Sizes} [sizes] of its discs
   */
  constructor({ heapFor, stepMs }, theme, sizes = SMALL_DISCS) {
    this.heapFor = heapFor;
    this.stepMs = stepMs;
    this.theme = theme;
    this.sizes = sizes;
  }

  /** Whether another frame must be drawn. */
  get runs() {
    return this.#heap?.runs ?? false;
  }

  /**
   * @param {Board} board
   * @param {TrayGeometry} geometry
   * @param {number} height of the tray, CSS pixels
   * @param {number[]} counts balls by bin
   */
  lay(board, geometry, height, counts) {
    const plan = planOf(board, geometry, height, this.sizes);
    if (JSON.stringify(plan) !== JSON.stringify(this.#plan)) {
      // If only the size of the tray has changed, the discs appear at rest, without falling again.
      this.#ahead = String(counts) === String(this.#counts);
      this.#plan = plan;
      this.#begin(counts, 1);
    } else this.update(counts, null);
  }

  /**
   * Empties the tray and lets all discs fall again.
   * @param {number[]} counts @param {number} least smallest number of balls that a disc may represent
   */
  #begin(counts, least) {
    if (!this.#plan) return;
    this.share = shareFor(counts, this.#plan, least);
    this.#heap = this.heapFor(this.#plan);
    if (!this.#ahead) this.#shown = [];
    this.#discs = counts.map(() => 0);
    this.#enter(counts, null);
  }

  /**
   * @param {number[]} counts balls by bin
   * @param {Entry | null} entry of the last landing, if known
   */
  update(counts, entry) {
    if (!this.#plan) return;
    const wanted = discsOf(counts, this.share);
    const fewer = wanted.some((count, bin) => count < this.#discs[bin]);
    const share = shareFor(counts, this.#plan, fewer ? 1 : this.share);
    if (fewer || share > this.share) this.#begin(counts, share);
    else this.#enter(counts, entry);
  }

  /** @param {number[]} counts @param {Entry | null} entry */
  #enter(counts, entry) {
    const { heap, plan } = { heap: this.#heap, plan: this.#plan };
    if (!heap || !plan) return;
    this.#counts = [...counts];
    discsOf(counts, this.share).forEach((wanted, bin) => {
      for (; this.#discs[bin] < wanted; this.#discs[bin] += 1) {
        heap.add(bin, entry ?? usualEntry(plan, bin, this.#discs[bin]));
      }
    });
  }

  /**
   * Advances the pile to a local time.
   * @param {number} nowMs
   * @param {boolean} still whether the visitor prefers reduced motion
   * @returns {boolean} whether the picture has changed
   */
  advance(nowMs, still) {
    const heap = this.#heap;
    if (!heap?.runs) {
      this.#clock = 0;
      return false;
    }
    const part = still || this.#ahead ? this.#hurry(heap) : this.#follow(heap, nowMs);
    if (heap.full) this.#begin(this.#counts, this.share + 1);
    if (part === null) return false;
    this.#shown = heap.look(part);
    return true;
  }

  /** @param {Heap} heap @returns {number | null} 1 when all discs are at rest, null before */
  #hurry(heap) {
    for (let step = 0; step < AHEAD_STEPS && heap.runs; step += 1) heap.step();
    if (heap.runs) return null;
    this.#ahead = false;
    return 1;
  }

  /** @param {Heap} heap @param {number} nowMs @returns {number} the part of the last step that has passed */
  #follow(heap, nowMs) {
    if (!this.#clock || nowMs - this.#clock > MOST_STEPS * this.stepMs) this.#clock = nowMs - this.stepMs;
    for (; this.#clock + this.stepMs <= nowMs && heap.runs; this.#clock += this.stepMs) heap.step();
    return heap.runs ? (nowMs - this.#clock) / this.stepMs : 1;
  }

  /**
   * @param {CanvasRenderingContext2D} ctx cleared, scaled to CSS pixels
   * @param {Board} board
   * @param {TrayGeometry} geometry
   * @param {number} height of the tray, CSS pixels
   * @param {(bin: number, ball: number) => string} colourOf ball: in order of landing, from 0
   */
  paint(ctx, board, geometry, height, colourOf) {
    this.#paintColumns(ctx, board, geometry, height);
    const { px, scale } = geometry;
    const stamps = this.#stampsFor((this.#plan?.radius ?? 0) * scale);
    for (const { bin, number, x, y, angle } of this.#shown) {
      // A disc for several balls has the colour of the last of them.
      const colour = colourOf(bin, (number + 1) * this.share - 1);
      paintBall(ctx, stamps.of({ mine: false, colour }).body, px(x), y * scale, angle);
    }
  }

  /**
   * @param {number} bin @param {number} balls @param {Pick<TrayGeometry, "scale">} geometry
   * @returns {number} approximate height of that many balls, CSS pixels
   */
  heightOf(bin, balls, { scale }) {
    if (!this.#plan) return 0;
    const { edges, floors, radius, height } = this.#plan;
    const area = ((balls / this.share) * Math.PI * radius ** 2) / DENSE;
    const low = floors[bin + 1] - floors[bin];
    const narrowing = (low - edges[bin + 1] + edges[bin]) / height;
    return (2 * area * scale) / (low + Math.sqrt(Math.max(0, low ** 2 - 2 * area * narrowing)));
  }

  /**
   * @param {CanvasRenderingContext2D} ctx @param {Board} board @param {TrayGeometry} geometry @param {number} height
   */
  #paintColumns(ctx, { bins: { edges } }, { px, spread }, height) {
    const floors = spreadOut(edges, spread);
    ctx.strokeStyle = this.theme.palette.trayInk;
    ctx.globalAlpha = 0.35;
    ctx.lineWidth = 1;
    ctx.beginPath();
    edges.forEach((edge, i) => {
      ctx.moveTo(px(edge), 0);
      ctx.lineTo(px(floors[i]), height);
    });
    ctx.moveTo(px(floors[0]), height - 0.5);
    ctx.lineTo(px(floors[floors.length - 1]), height - 0.5);
    ctx.stroke();
    ctx.globalAlpha = 1;
  }

  /** @param {number} radius CSS pixels @returns {StampBook} */
  #stampsFor(radius) {
    const density = window.devicePixelRatio || 1;
    const { palette, shapes } = this.theme;
    const kept = this.#stamps;
    if (kept?.radius === radius && kept.density === density && kept.theme.palette === palette) return kept;
    this.#stamps = new StampBook(radius, density, { palette, shapes });
    return this.#stamps;
  }
}
