// Tells what drops came to: each by itself, a round of several in one line. Pure but for time.

import { t } from "../../texts/text.js";
import { amount, multiplier, plain } from "../../util/format.js";

const PAUSE_MS = 1500; // between two sentences: a listener hears each to its end

/**
 * @typedef {{left: number, count: number, staked: number, paid: number, scores: number, practice: boolean}} Round
 * @typedef {{bin: number | null, score: number, seed: string, stake?: number,
 *   practice?: boolean, near?: string}} Result near: how near it came to more, or nothing
 */

/** Collects results and says them through `say(text, score)`. */
export class Announcer {
  /** @type {Result | null} the newest; the others live on in the sums */
  #last = null;
  #timer = 0;
  #lastMs = Number.NEGATIVE_INFINITY;
  #count = 0;
  #paid = 0;
  #staked = 0;
  #practice = true; // all that is counted
  /** Balls of one push: how many are still to land, and what they come to. @type {Round | null} */
  #round = null;

  /** @param {(text: string, score?: number) => void} say */
  constructor(say) {
    this.say = say;
  }

  /**
   * So many balls of one push are to be told in one line, once they are down.
   * @param {number} count
   * @param {boolean} alone nothing of ours is in flight: what is left of a round before will not come
   */
  expect(count, alone) {
    if (alone || !this.#round) {
      this.#round = { left: 0, count: 0, staked: 0, paid: 0, scores: 0, practice: true };
    }
    this.#round.left += count;
    this.#round.count += count;
    this.say(t("play.balls-fall", { n: this.#round.count }));
  }

  /** Whether balls of a round are still to land. */
  get counts() {
    return this.#round !== null;
  }

  /** @param {Result} result @returns {boolean} whether the last of a round is down */
  #counted({ score, stake = 1, practice = false }) {
    const round = this.#round;
    if (!round) return false;
    round.left -= 1;
    round.staked += stake;
    round.paid += stake * score;
    round.scores += score;
    round.practice &&= practice;
    return round.left <= 0;
  }

  /** @param {Round} round */
  #end({ count, staked, paid, scores, practice }) {
    clearTimeout(this.#timer);
    this.#timer = 0;
    this.#round = null;
    this.#forget();
    const words = practice
      ? t("play.round-practice", { n: count, mean: amount(scores / count) })
      : t("play.round", { n: count, paid: amount(paid), staked: plain(staked) });
    this.say(words, scores / count);
  }

  /** @param {Result} result */
  add(result) {
    if (this.#counted(result) && this.#round) {
      this.#end(this.#round);
      return;
    }
    this.#last = result;
    this.#count += 1;
    this.#practice &&= result.practice ?? false;
    this.#staked += result.stake ?? 1;
    this.#paid += (result.stake ?? 1) * result.score;
    if (this.#timer !== 0) return;
    const wait = this.#lastMs + PAUSE_MS - performance.now();
    if (wait <= 0) this.#tell();
    else this.#timer = setTimeout(() => this.#tell(), wait);
  }

  #tell() {
    this.#timer = 0;
    this.#lastMs = performance.now();
    const last = this.#last;
    if (!last) return;
    this.say(this.#count === 1 ? sentence(last) : this.#summary(last),
      last.bin === null ? undefined : last.score);
    this.#forget();
  }

  /** @param {Result} last */
  #summary(last) {
    const n = this.#count;
    const came = this.#practice
      ? t("play.landed-practice", { n })
      : t("play.landed", { n, paid: amount(this.#paid), staked: plain(this.#staked) });
    const { bin, score } = last;
    return `${came} ${bin === null ? t("play.last-none") : t("play.last-bin", { bin, pays: multiplier(score) })}`;
  }

  #forget() {
    this.#practice = true;
    this.#count = 0;
    this.#paid = 0;
    this.#staked = 0;
  }
}

/** @param {Result} result */
function sentence({ bin, score, seed, stake = 1, practice = false, near = "" }) {
  if (bin === null) {
    if (practice) return t("play.practice-none", { seed });
    return stake ? t("play.rests-back", { seed }) : t("play.rests", { seed });
  }
  const told = { bin, seed, pays: multiplier(score) };
  if (practice) return t("play.practice-bin", told) + near;
  if (stake === 0) return t("play.lands-free", told);
  if (stake === 1) return t("play.pays", told) + near;
  return t("play.pays-stake", { ...told, paid: amount(stake * score), stake: plain(stake) }) + near;
}
