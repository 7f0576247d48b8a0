// Balls that are told together: those of one push, of several while some still fall, or of an auto-drop.

import { t } from "../texts/text.js";
import { amount, multiplier, plain, signed } from "../util/format.js";

/** @import { Played } from "../model/player/account.js" */

const ENDS = /** @type {const} */ ({
  win: "auto.win", loss: "auto.loss", finished: "auto.finished", player: "auto.player", refused: "auto.refused",
  credits: "auto.credits",
});
const SHOWER_RATE = 12; // a second: several balls of one push, told apart and within any limit

/** @typedef {keyof typeof ENDS} Stop why an auto-drop ended */

/** What was dropped together, and what it has come to. */
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
   * Balls that are still to be dropped at a steady rate, the next of them at a certain moment.
   * @type {{left: number, nextMs: number, spacing: number, drop: () => string | null}[]}
   */
  #showers = [];
  /** @type {Stop | null} */
  stopped = null;

  /** @param {{win: number, loss: number} | null} [limits] of an auto-drop: profit and loss that end it */
  constructor(limits = null) {
    this.limits = limits;
  }

  /** Balls that are still to be dropped; infinite without an end. */
  get left() {
    return this.#showers.reduce((sum, { left }) => sum + left, 0);
  }

  get falling() {
    return this.#open.size;
  }

  get over() {
    return this.left === 0 && this.#open.size === 0;
  }

  /** What has landed came to, less its stakes. */
  get profit() {
    return Math.round(100 * (this.paid - this.staked)) / 100;
  }

  /**
   * @param {number} count balls
   * @param {() => string | null} drop makes one, and returns its ref; null where it could not be asked for
   * @param {number} nowMs @param {number} [rate] a second
   */
  add(count, drop, nowMs, rate = SHOWER_RATE) {
    this.#showers.push({ left: count, nextMs: nowMs, spacing: 1000 / rate, drop });
  }

  /**
   * Drops what is due.
   * @param {number} nowMs @param {() => boolean} hasRoom whether the table takes another ball now
   * @returns {number} ms until the next is due; infinite when there is none
   */
  give(nowMs, hasRoom) {
    for (const shower of this.#showers) {
      const { nextMs, spacing } = shower;
      if (nowMs < nextMs) continue;
      if (!hasRoom()) {
        shower.nextMs = nowMs + spacing;
        continue;
      }
      // After a pause (a hidden tab's timers sleep) what was missed is not made up for.
      shower.nextMs = Math.max(nextMs + spacing, nowMs + 0.5 * spacing);
      shower.left -= 1;
      const ref = shower.drop();
      if (ref === null) {
        this.stop("refused"); // unless there was another reason
        break;
      }
      this.#open.add(ref);
    }
    this.#showers = this.#showers.filter(({ left }) => left > 0);
    if (this.limits && this.#showers.length === 0) this.stopped ??= "finished";
    return Math.min(...this.#showers.map(({ nextMs }) => Math.max(0, nextMs - nowMs)));
  }

  /** Nothing more is dropped; what is in flight still counts. @param {Stop} why */
  stop(why) {
    this.#showers = [];
    this.stopped ??= why;
  }

  /** @param {Played} played @returns {boolean} whether it was one of these */
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

  /** @param {string} ref the table did not take this one @returns {boolean} whether it was one of these */
  refuse(ref) {
    return this.#open.delete(ref);
  }

  /** @returns {{text: string, score?: number} | null} what it came to, once all are down; null when nothing did */
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

/** @param {Played} played one ball @returns {string} */
function sentence({ bin, score, stake, paid, practice = false }) {
  if (bin === null) return t(practice ? "play.rests" : "play.rests-back");
  const pays = multiplier(score);
  return practice ? t("play.pays-practice", { pays }) : t("play.pays", { pays, profit: signed(paid - stake) });
}
