// Tells what drops came to: each by itself, or a shower of them in one sentence. Pure but for time.

import { amount, counted, multiplier, plain } from "../util/format.js";

const PAUSE_MS = 1500; // between two sentences: a listener hears each to its end

/**
 * @typedef {{bin: number | null, score: number, seed: string, stake?: number,
 *   practice?: boolean}} Result
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

  /** @param {(text: string, score?: number) => void} say */
  constructor(say) {
    this.say = say;
  }

  /** @param {Result} result */
  add(result) {
    this.#last = result;
    this.#count += 1;
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
    this.say(this.#count === 1 ? sentence(last) : summary(this.#count, this.#staked, this.#paid, last),
      last.bin === null ? undefined : last.score);
    this.#count = 0;
    this.#paid = 0;
    this.#staked = 0;
  }
}

/** @param {Result} result */
function sentence({ bin, score, seed, stake = 1, practice = false }) {
  if (practice) {
    const where = bin === null ? "no bin" : `bin ${bin}, ${multiplier(score)}`;
    return `Practice: ${where} for seed ${seed}.`;
  }
  if (bin === null) return `Seed ${seed} came to rest in no bin.${stake ? " Its stake is back." : ""}`;
  if (stake === 0) return `Seed ${seed} lands in bin ${bin}, ${multiplier(score)}. Nothing was staked.`;
  const worth = stake === 1 ? "" : `, ${amount(stake * score)} for ${plain(stake)},`;
  return `Bin ${bin} pays ${multiplier(score)}${worth} for seed ${seed}.`;
}

/** @param {number} count @param {number} staked @param {number} paid @param {Result} last */
function summary(count, staked, paid, last) {
  return `${counted(count, "ball")} landed: ${amount(paid)} back for ${plain(staked)}. ` +
    `The last: ${last.bin === null ? "no bin" : `bin ${last.bin}, ${multiplier(last.score)}`}.`;
}
