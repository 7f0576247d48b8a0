// Balls whose result is reported together: of one press, of several presses in one go, or of an auto-drop.

import { t } from "../texts/text.js";
import { amount, multiplier, signed } from "../util/format.js";

/** @import { Played } from "../model/player/account.js" */

const ENDS = /** @type {const} */ ({
  win: "auto.win", loss: "auto.loss", finished: "auto.finished", player: "auto.player", refused: "auto.refused",
  credits: "auto.credits", cut: "auto.cut",
});
const SHOWER_RATE = 12; // balls a second of a press: the eye can tell them apart

/**
 * @typedef {keyof typeof ENDS} Stop why an auto-drop ended
 * @typedef {"keep" | "times" | "reset"} Reaction what a result does to the next stake; reset: back to the first one
 * @typedef {{how: Reaction, factor: number}} Step
 * @typedef {{win: number, loss: number, onWin: Step, onLoss: Step}} Limits profit and loss, in credits, that end an
 *   auto-drop; infinite without one
 * @typedef {{ref: string, stake: number}} Dropped stake: credits, 0 in practice
 * @typedef {{stake: () => number, drop: (stake: number) => Dropped | Stop}} Dropper makes the next ball, or says why it
 *   cannot; stake: of that ball, credits
 */

/** Balls dropped together, all with a stake or all for practice, and the sums of their results. */
export class DropSeries {
  staked = 0;
  paid = 0;
  #down = 0; // balls that have landed
  #scores = 0; // sum of their multipliers
  /** How many times the first stake the next ball takes. */
  factor = 1;
  #asked = 0;
  #refused = 0;
  /** @type {Played | null} */
  #last = null;
  /** Stakes of the balls in flight, by ref. @type {Map<string, number>} */
  #open = new Map();
  /** Balls still to be dropped, the first shower first. @type {(Dropper & {left: number, spacing: number})[]} */
  #queue = [];
  #nextMs = Number.NEGATIVE_INFINITY;
  /** @type {Stop | null} */
  stopped = null;

  /** @param {{practice?: boolean, limits?: Limits | null}} [options] practice: whether its balls were asked for as practice */
  constructor({ practice = false, limits = null } = {}) {
    this.practice = practice;
    this.limits = limits;
  }

  /** Balls still to be dropped; infinite for an auto-drop without an end. */
  get left() {
    return this.#queue.reduce((sum, { left }) => sum + left, 0);
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

  /** @param {number} count balls @param {Dropper} dropper @param {number} nowMs @param {number} [rate] a second */
  add(count, dropper, nowMs, rate = SHOWER_RATE) {
    if (this.#queue.length === 0) this.#nextMs = Math.max(this.#nextMs, nowMs);
    this.#queue.push({ ...dropper, left: count, spacing: 1000 / rate });
    this.#asked += count;
  }

  /** Adds a ball that is in flight already. @param {Dropped} ball */
  adopt({ ref, stake }) {
    this.#open.set(ref, stake);
  }

  /**
   * Drops the balls that are due.
   * @param {number} nowMs @param {() => boolean} hasRoom whether the room has space for another ball
   * @returns {number} ms until the next ball is due; infinite without one
   */
  give(nowMs, hasRoom) {
    const [shower] = this.#queue;
    if (shower && nowMs >= this.#nextMs) {
      const stake = shower.stake();
      const limit = this.#limit(stake);
      if (limit === "wait" || (limit === null && !hasRoom())) this.#nextMs = nowMs + shower.spacing;
      else if (limit !== null) this.stop(limit);
      else this.#drop(shower, stake, nowMs);
    }
    if (this.limits && this.#queue.length === 0) this.stopped ??= "finished";
    return this.#queue.length ? Math.max(0, this.#nextMs - nowMs) : Number.POSITIVE_INFINITY;
  }

  /** @param {Dropper & {left: number, spacing: number}} shower @param {number} stake @param {number} nowMs */
  #drop(shower, stake, nowMs) {
    // The timers of a hidden tab sleep: missed balls are not caught up, so that they do not come all at once.
    this.#nextMs = Math.max(this.#nextMs + shower.spacing, nowMs + 0.5 * shower.spacing);
    const ball = shower.drop(stake);
    if (typeof ball === "string") {
      this.stop(ball);
      return;
    }
    this.#open.set(ball.ref, ball.stake);
    shower.left -= 1;
    if (shower.left === 0) this.#queue.shift();
  }

  /**
   * What the limits say of one more ball. The balls in flight may lose their stakes: they count as lost for the loss
   * limit, and a profit counts once they have landed.
   * @param {number} stake of the ball @returns {Stop | "wait" | null} null: it may fall
   */
  #limit(stake) {
    if (!this.limits) return null;
    const { win, loss, onWin, onLoss } = this.limits;
    const risk = [...this.#open.values()].reduce((sum, each) => sum + each, 0);
    /** @type {Stop | null} */
    let stop = null;
    if (this.profit >= win) stop = "win";
    else if (Math.round(100 * (risk + stake - this.profit)) > Math.round(100 * loss)) stop = "loss";
    // A stake that follows from the last result needs that result.
    const follows = stake > 0 && (onWin.how !== "keep" || onLoss.how !== "keep");
    return this.#open.size > 0 && (stop || follows) ? "wait" : stop;
  }

  /** Drops no more balls; those in flight still count. @param {Stop} why */
  stop(why) {
    this.#queue = [];
    this.stopped ??= why;
  }

  /** @param {Played} played @returns {boolean} whether the ball belongs to this series */
  land(played) {
    const { ref = "", stake, paid, score } = played;
    if (!this.#open.delete(ref)) return false;
    this.#last = played;
    this.#down += 1;
    this.#scores += score;
    if (this.practice) return true;
    this.staked += stake;
    this.paid += paid;
    if (this.limits && paid > stake) this.#step(this.limits.onWin);
    if (this.limits && paid < stake) this.#step(this.limits.onLoss);
    return true;
  }

  /** @param {Step} step */
  #step({ how, factor }) {
    if (how === "times") this.factor *= factor;
    if (how === "reset") this.factor = 1;
  }

  /** @param {string} ref of a refused drop @returns {boolean} whether it belongs to this series */
  refuse(ref) {
    if (!this.#open.delete(ref)) return false;
    this.#refused += 1;
    return true;
  }

  /** @returns {{text: string, score?: number} | null} the result once all balls have landed; null if none did */
  words() {
    if (this.limits) return { text: this.#ending() };
    const last = this.#last;
    if (!last) return null;
    const n = this.#down;
    if (n === 1) return { text: sentence(last), score: last.bin === null ? undefined : last.score };
    const mean = this.#scores / n;
    if (this.practice) return { text: t("play.round-practice", { n, mean: amount(mean) }), score: mean };
    return { text: t("play.round", { n, ...sumsOf(this) }), score: this.paid / this.staked };
  }

  /** @returns {string} how the auto-drop ended */
  #ending() {
    const stop = this.stopped ?? "finished";
    const why = stop === "finished" && this.#refused > 0 ? "cut" : stop;
    const profit = this.practice ? t("practice.word") : signed(this.profit);
    return t(ENDS[why], { n: this.#down, all: this.#asked, profit });
  }
}

/** @param {Played} played @returns {string} */
function sentence({ bin, score, stake, paid, practice = false }) {
  if (bin === null) return t(practice ? "play.rests" : "play.rests-back");
  const pays = multiplier(score);
  return practice ? t("play.pays-practice", { pays }) : t("play.pays", { pays, ...sumsOf({ staked: stake, paid }) });
}

/**
 * Sums as texts, as every message says them.
 * @param {{staked: number, paid: number}} sums credits
 */
export function sumsOf({ staked, paid }) {
  return { staked: amount(staked), paid: amount(paid), profit: signed(paid - staked) };
}
