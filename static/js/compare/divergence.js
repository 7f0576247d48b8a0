// How far apart two drops are, and when they part. Pure.

/** @import { Motion } from "../model/motion/drop.js" */

const SAMPLES = 240; // a second; the parting is then found by halving

/** Smallest distance shown, m: the square of a rounding error of metres. */
export const FLOOR = 1e-18;

/** Two drops at once. Distances are between the balls' centres, in metres. */
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

  /** @param {number} t seconds */
  at(t) {
    const [a, b] = [this.one.stateAt(t), this.two.stateAt(t)];
    return Math.hypot(a.x - b.x, a.y - b.y);
  }

  /** The distance against time, both balls' events included. */
  get overTime() {
    if (this.#overTime) return this.#overTime;
    const times = Array.from({ length: Math.ceil(this.end * SAMPLES) }, (_, i) => i / SAMPLES);
    for (const { t } of [...this.one.events, ...this.two.events]) if (t < this.end) times.push(t);
    this.#overTime = [...times, this.end].sort((a, b) => a - b).map((t) => ({ x: t, y: this.at(t) }));
    return this.#overTime;
  }

  /** The distance when the first ball makes its nth hit; the 0th is the start. */
  get overHits() {
    const hits = this.one.hits.filter(({ t }) => t <= this.end);
    return [{ t: 0 }, ...hits].map(({ t }, hit) => ({ x: hit, y: this.at(t) }));
  }

  /**
   * When the balls first are further apart than a limit.
   * @param {number} limit metres
   * @returns {{t: number, hits: number} | null} hits: how often the first ball had hit by then
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
   * By how much each hit multiplied the distance until they parted: the geometric mean.
   * @param {number} limit metres
   * @returns {number | null} null without a hit, or when they started more than a limit apart
   */
  growthPerHit(limit) {
    const parted = this.parting(limit);
    const start = this.at(0);
    if (!parted || parted.hits === 0 || start === 0 || start >= limit) return null;
    return (limit / start) ** (1 / parted.hits);
  }
}
