// Balls whose result is reported together: of one press, of several presses in one go, or of an auto-drop.

import { t } from "../texts/text.js";
import { amount, multiplier, plain, signed } from "../util/format.js";

/** @import { Played } from "../model/player/account.js" */

const ENDS = /** @type {const} */ ({
  win: "auto.win", loss: "auto.loss", finished: "auto.finished", player: "auto.player", refused: "auto.refused",
  credits: "auto.credits",
});
const SHOWER_RATE = 12; // balls a second of one press: the eye can tell them apart, and no rate limit refuses them

/** @typedef {keyof typeof ENDS} Stop why an auto-drop ended */

/** Balls dropped together, and the sum of their results. */
export class Run {
  staked = 0;
  paid = 0;
  #scores = 0;
  #down = 0;
  #practice = true;
  /** @type {Played | null} */
  #last = null;
  /** @type {Set<string>} refs of balls in flight */
  #open = new Set();
  /**
   * Balls still to be dropped at a steady rate.
   * @type {{left: number, nextMs: number, spacing: number, drop: () => string | null}[]}
   */
  #showers = [];
  /** @type {Stop | null} */
  stopped = null;

  /** @param {{win: number, loss: number} | null} [limits] profit and loss, in credits, that end an auto-drop */
  constructor(limits = null) {
    this.limits = limits;
  }

  /** Balls still to be dropped; infinite for an auto-drop without an end. */
  get left() {
    return this.#showers.reduce((sum, { left }) => sum + left, 0);
  }

  get falling() {
    return this.#open.size;
  }

  get over() {
    return this.left === 0 && this.#open.size === 0;
  }

  /** Payouts minus stakes of the balls that have landed, credits. */
  get profit() {
    return Math.round(100 * (this.paid - this.staked)) / 100;
  }

  /**
   * @param {number} count balls
   * @param {() => string | null} drop drops one ball and returns its ref; null if that failed
   * @param {number} nowMs @param {number} [rate] a second
   */
  add(count, drop, nowMs, rate = SHOWER_RATE) {
    this.#showers.push({ left: count, nextMs: nowMs, spacing: 1000 / rate, drop });
  }

  /**
   * Drops the balls that are due.
   * @param {number} nowMs @param {() => boolean} hasRoom whether the room has space for another ball
   * @returns {number} ms until the next ball is due; infinite without one
   */
  give(nowMs, hasRoom) {
    for (const shower of this.#showers) {
      const { nextMs, spacing } = shower;
      if (nowMs < nextMs) continue;
      if (!hasRoom()) {
        shower.nextMs = nowMs + spacing;
        continue;
      }
      // The timers of a hidden tab sleep: missed balls are not caught up, so that they do not come all at once.
      shower.nextMs = Math.max(nextMs + spacing, nowMs + 0.5 * spacing);
      shower.left -= 1;
      const ref = shower.drop();
      if (ref === null) {
        this.stop("refused"); // keeps an earlier reason
        break;
      }
      this.#open.add(ref);
    }
    this.#showers = this.#showers.filter(({ left }) => left > 0);
    if (this.limits && this.#showers.length === 0) this.stopped ??= "finished";
    return Math.min(...this.#showers.map(({ nextMs }) => Math.max(0, nextMs - nowMs)));
  }

  /** Drops no more balls; those in flight still count. @param {Stop} why */
  stop(why) {
    this.#showers = [];
    this.stopped ??= why;
  }

  /** @param {Played} played @returns {boolean} whether the ball belongs to this run */
  land(played) {
    const { ref = "", stake, paid, score, practice = false } = played;
    if (!this.#open.delete(ref)) return false;
    this.#down += 1;
    this.#last = played;
    this.#scores += score;
    if (!practice) {
      this.#practice = false;
      this.staked += stake;
      this.paid += paid;
      if (this.limits && this.profit >= this.limits.win) this.stop("win");
      else if (this.limits && this.profit <= -this.limits.loss) this.stop("loss");
    }
    return true;
  }

  /** @param {string} ref of a refused drop @returns {boolean} whether it belongs to this run */
  refuse(ref) {
    return this.#open.delete(ref);
  }

  /** @returns {{text: string, score?: number} | null} the result once all balls have landed; null if none did */
  words() {
    const [n, last] = [this.#down, this.#last];
    const profit = signed(this.profit);
    if (this.limits) return { text: t(ENDS[this.stopped ?? "finished"], { n, profit }) };
    if (!last) return null;
    if (n === 1) return { text: sentence(last), score: last.bin === null ? undefined : last.score };
    const mean = this.#scores / n;
    const text = this.#practice
      ? t("play.round-practice", { n, mean: amount(mean) })
      : t("play.round", { n, staked: plain(this.staked), paid: amount(this.paid), profit });
    return { text, score: mean };
  }
}

/** @param {Played} played @returns {string} */
function sentence({ bin, score, stake, paid, practice = false }) {
  if (bin === null) return t(practice ? "play.rests" : "play.rests-back");
  const pays = multiplier(score);
  return practice ? t("play.pays-practice", { pays }) : t("play.pays", { pays, profit: signed(paid - stake) });
}
