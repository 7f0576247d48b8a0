// The pile in the tray: what has landed as discs that fall, roll and rest, each for one ball or for some.

import { paintBall } from "../../paint/ball.js";
import { StampBook } from "../../paint/stamps.js";
import { discsOf, planOf, shareFor, SMALL_DISCS, usualEntry } from "./columns.js";

/** @import { Board } from "../../model/board.js" */
/** @import { Geometry } from "../../paint/geometry.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Entry, Plan, Sizes } from "./columns.js" */
/** @import { Heap, openHeaps } from "./heap.js" */

const MOST_STEPS = 4; // for one picture: on a slow machine discs fall slowly, and the board does not wait
const AHEAD_STEPS = 8; // for one picture that shows none of them
const DENSE = 0.8; // of a column's area that discs take which lie well
const FIELDS = 5; // of a disc that is shown, see Heap.look

/**
 * Fetches what moves it; throws where that cannot be.
 * @param {Theme} theme @param {Sizes} [sizes] of its discs
 * @returns {Promise<Pile>}
 */
export async function openPile(theme, sizes = SMALL_DISCS) {
  /** @type {{openHeaps: typeof openHeaps}} */
  const moving = await import(new URL("heap.js", import.meta.url).href);
  return new Pile(await moving.openHeaps(), theme, sizes);
}

/** One tray's pile. Nothing is computed and no picture asked for while all discs are at rest. */
export class Pile {
  /** How many balls a disc stands for. */
  share = 1;
  /** @type {Heap | null} null until it is known where it stands */
  #heap = null;
  /** @type {Plan | null} */
  #plan = null;
  /** @type {number[]} */
  #counts = [];
  /** Discs by column, those that are still to enter too. @type {number[]} */
  #discs = [];
  /** Discs as they are shown, FIELDS for each. */
  #shown = new Float64Array(0);
  /** The moment of the last step, ms; 0 while nothing moves. */
  #clock = 0;
  /** Nothing is shown until all discs rest. */
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

  /** Whether a picture is wanted soon. */
  get runs() {
    return this.#heap?.runs ?? false;
  }

  /**
   * @param {Board} board
   * @param {Geometry} geometry
   * @param {number} height of the tray, CSS pixels
   * @param {number[]} counts balls by bin
   */
  lay(board, geometry, height, counts) {
    const plan = planOf(board, geometry, height, this.sizes);
    if (JSON.stringify(plan) !== JSON.stringify(this.#plan)) {
      // In a tray of another size the same discs lie as if they had always lain there.
      this.#ahead = String(counts) === String(this.#counts);
      this.#plan = plan;
      this.#begin(counts, 1);
    } else this.update(counts, null);
  }

  /**
   * The pile is swept, and comes down anew.
   * @param {number[]} counts @param {number} least of balls that a disc stands for
   */
  #begin(counts, least) {
    if (!this.#plan) return;
    this.share = shareFor(counts, this.#plan, least);
    this.#heap = this.heapFor(this.#plan);
    if (!this.#ahead) this.#shown = new Float64Array(0);
    this.#discs = counts.map(() => 0);
    this.#enter(counts, null);
  }

  /**
   * @param {number[]} counts balls by bin
   * @param {Entry | null} entry how the ball came that landed last, if one did
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
   * Moves it on to a local time.
   * @param {number} nowMs
   * @param {boolean} still nobody wants to see discs move
   * @returns {boolean} whether it looks otherwise than before
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

  /** @param {Heap} heap @returns {number | null} 1 once all discs rest */
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
   * @param {Geometry} geometry
   * @param {number} height of the tray, CSS pixels
   * @param {(bin: number, ball: number) => string} colourOf the ball that is so many in a bin, from 0
   */
  paint(ctx, board, geometry, height, colourOf) {
    this.#paintColumns(ctx, board, geometry, height);
    const { px, scale } = geometry;
    const stamps = this.#stampsFor((this.#plan?.radius ?? 0) * scale);
    for (let at = 0; at < this.#shown.length; at += FIELDS) {
      const [bin, x, y, angle, number] = this.#shown.subarray(at, at + FIELDS);
      // A disc that stands for several came with the last of them.
      const colour = colourOf(bin, (number + 1) * this.share - 1);
      paintBall(ctx, stamps.of({ mine: false, colour }).body, px(x), y * scale, angle);
    }
  }

  /**
   * @param {number} bin @param {number} balls @param {Pick<Geometry, "scale">} geometry
   * @returns {number} about how high they lie there, CSS pixels
   */
  heightOf(bin, balls, { scale }) {
    if (!this.#plan) return 0;
    const { edges, radius } = this.#plan;
    return ((balls / this.share) * Math.PI * radius ** 2 * scale) / (DENSE * (edges[bin + 1] - edges[bin]));
  }

  /**
   * @param {CanvasRenderingContext2D} ctx @param {Board} board @param {Geometry} geometry @param {number} height
   */
  #paintColumns(ctx, { bins: { edges } }, { px }, height) {
    ctx.strokeStyle = this.theme.palette.trayInk;
    ctx.globalAlpha = 0.35;
    ctx.lineWidth = 1;
    ctx.beginPath();
    for (const edge of edges) {
      ctx.moveTo(px(edge), 0);
      ctx.lineTo(px(edge), height);
    }
    ctx.moveTo(px(edges[0]), height - 0.5);
    ctx.lineTo(px(edges[edges.length - 1]), height - 0.5);
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
