// The distance between two drops over time, and when they part. Pure.

/** @import { Motion } from "../model/motion/drop.js" */

const SAMPLES = 240; // a second; bisection then refines the time of the parting

/** Smallest distance on the chart, m. */
export const FLOOR = 1e-18;

/** Two drops compared. Distances are between the balls' centres, m. */
export class Divergence {
  /** @type {{x: number, y: number}[] | null} */
  #overTime = null;

  /** @param {Motion} one @param {Motion} two */
  constructor(one, two) {
    this.one = one;
    this.two = two;
    /** Seconds for which both balls are on the board. */
    this.end = Math.min(one.duration, two.duration);
  }

  /** @param {number} t s @returns {number} the distance, m */
  at(t) {
    const [a, b] = [this.one.stateAt(t), this.two.stateAt(t)];
    return Math.hypot(a.x - b.x, a.y - b.y);
  }

  /** The distance against time, sampled also at both balls' events. */
  get overTime() {
    if (this.#overTime) return this.#overTime;
    const times = Array.from({ length: Math.ceil(this.end * SAMPLES) }, (_, i) => i / SAMPLES);
    for (const { t } of [...this.one.events, ...this.two.events]) if (t < this.end) times.push(t);
    this.#overTime = [...times, this.end].sort((a, b) => a - b).map((t) => ({ x: t, y: this.at(t) }));
    return this.#overTime;
  }

  /** The distance at the first ball's nth impact; 0 is the start. */
  get overHits() {
    const hits = this.one.hits.filter(({ t }) => t <= this.end);
    return [{ t: 0 }, ...hits].map(({ t }, hit) => ({ x: hit, y: this.at(t) }));
  }

  /**
   * Finds when the balls are first farther apart than a limit.
   * @param {number} limit m
   * @returns {{t: number, hits: number} | null} hits: the first ball's impacts until then
   */
  parting(limit) {
    const rows = this.overTime;
    const found = rows.findIndex(({ y }) => y > limit);
    if (found < 0) return null;
    let early = found ? rows[found - 1].x : 0;
    let late = rows[found].x;
    for (let i = 0; i < 50; i += 1) {
      const middle = (early + late) / 2;
      if (this.at(middle) > limit) late = middle;
      else early = middle;
    }
    return { t: late, hits: this.one.hits.filter(({ t }) => t <= late).length };
  }

  /**
   * The geometric mean of the factors by which the first ball's impacts multiplied the distance until the parting.
   * @param {number} limit m
   * @returns {number | null} null without a parting or an impact, or if they started farther apart than the limit
   */
  growthPerHit(limit) {
    const parted = this.parting(limit);
    const start = this.at(0);
    if (!parted || parted.hits === 0 || start === 0 || start >= limit) return null;
    return (limit / start) ** (1 / parted.hits);
  }
}
