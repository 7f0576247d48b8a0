// Judges the table's histogram and the returns: what chance allows, in numbers.

import { getJson } from "../net/api.js";
import { byId, make } from "../util/dom.js";
import { expectedOf } from "./binomial.js";
import { counted } from "../util/format.js";
import { fitTest, Mean, sameTest } from "../model/statistics.js";

const CONFIDENCE = 0.95;
const SAMPLE = 10_000; // drops that the server computes for the measured expectation
const TELL_MS = 500;
const UNLIKELY = 0.01;

/** @typedef {{label: string, chances: number[], counts?: number[]}} Expected */

/** The fit and the returns; `onExpected(expected)` gives what the histogram is compared with. */
export class FitMeter {
  /** @type {Expected | null} */
  expected = null;
  #told = "";
  #toldMs = 0;
  #waiting = "";
  #measured = new Map();

  /** @param {(expected: Expected | null) => void} onExpected @param {(text: string) => void} say */
  constructor(onExpected, say) {
    this.onExpected = onExpected;
    this.say = say;
    this.choices = [...document.querySelectorAll("input[name=against]")];
    for (const choice of this.choices) choice.addEventListener("change", () => this.#choose());
  }

  /** @param {any} hello of the table @param {boolean} seen whether anyone looks at the panel */
  setTable({ board, board_digest: digest, board_name: name }, seen) {
    // A line that came back finds the choice as it was made.
    if (digest === this.digest) return;
    this.board = board;
    this.digest = digest;
    this.binomial = expectedOf(name, board.bins.multipliers.length);
    const [fair, measured] = this.choices;
    fair.disabled = this.binomial === null;
    if (this.binomial === null) measured.checked = true;
    else fair.checked = true;
    this.#choose(seen);
  }

  /** @param {boolean} asked only then is the server made to work for it */
  async #choose(asked = true) {
    const measured = this.choices.find(({ checked }) => checked).value === "measured";
    const { digest } = this;
    if (!measured) this.#take(this.binomial);
    else if (this.#measured.has(digest)) this.#take(this.#measured.get(digest));
    else if (!asked) this.#take(null);
    else await this.#measure(digest);
  }

  async #measure(digest) {
    this.#waiting = `The server drops ${counted(SAMPLE, "ball")}…`;
    this.#take(null);
    try {
      const headers = { "content-type": "application/json" };
      const body = JSON.stringify({ board: this.board, drops: SAMPLE });
      const { histogram } = await getJson("simulate", { method: "POST", headers, body });
      const total = histogram.reduce((sum, count) => sum + count, 0);
      const label = `measured, ${counted(total, "drop")}`;
      const chances = histogram.map((count) => count / total);
      // One board is kept: a new one is measured anew in a moment.
      this.#measured = new Map([[digest, { label, chances, counts: histogram }]]);
      if (digest === this.digest) this.#take(this.#measured.get(digest));
    } catch (error) {
      this.#waiting = `The expected histogram could not be measured: ${error.message}`;
      this.say(this.#waiting);
      this.#take(null);
    }
  }

  #take(expected) {
    this.expected = expected;
    this.#told = "";
    this.onExpected(expected);
  }

  /** The panel was opened: what it needs is fetched. */
  open() {
    this.#choose();
  }

  /**
   * @param {number[]} counts of the table
   * @param {Mean} own of this visitor's scores
   * @returns {boolean} whether there is more to tell
   */
  show(counts, own, nowMs) {
    const state = `${counts.join()} ${own.count} ${this.expected?.label}`;
    if (state === this.#told) return false;
    if (nowMs - this.#toldMs < TELL_MS) return true;
    this.#told = state;
    this.#toldMs = nowMs;
    this.#showFit(counts);
    this.#showReturns(counts, own);
    return false;
  }

  #showFit(counts) {
    const total = counts.reduce((sum, count) => sum + count, 0);
    const { expected } = this;
    const fit = expected && judge(counts, expected);
    const reading = byId("fit-p");
    reading.textContent = fit ? `p = ${probability(fit.p)}` : "–";
    reading.parentElement.dataset.tone = fit && fit.p < UNLIKELY ? "bad" : "";
    if (!expected) {
      byId("fit-note").textContent = this.#waiting;
    } else if (!fit) {
      byId("fit-note").textContent =
        `${counted(total, "drop")} landed: too few to judge. Ten or so begin to tell.`;
    } else {
      byId("fit-note").textContent =
        `G = ${fit.statistic.toFixed(1)} with ${counted(fit.freedom, "degree")} of freedom, ` +
        `${counted(total, "drop")}. ${verdict(fit.p)}`;
    }
  }

  #showReturns(counts, own) {
    const { multipliers } = this.board.bins;
    const table = new Mean();
    counts.forEach((count, bin) => table.add(multipliers[bin], count));
    byId("returns").replaceChildren(row("Yours", own), row("The table's", table));
    const due = this.expected?.chances.reduce((sum, chance, bin) => sum + chance * multipliers[bin], 0);
    byId("returns-note").textContent = due === undefined
      ? ""
      : `Expected (${this.expected.label}): ${percent(due)}. Rare bins pay most, so it takes ` +
        "many drops to come near.";
  }
}

/** @param {number[]} counts @param {Expected} expected */
export function judge(counts, { chances, counts: sample }) {
  return sample ? sameTest(counts, sample) : fitTest(counts, chances);
}

function verdict(p) {
  if (p < UNLIKELY) return "Chance alone would hardly differ so much.";
  return "Chance alone differs as much as that.";
}

/** @param {number} p @returns {string} two digits that tell; tiny ones as a bound */
export function probability(p) {
  if (p < 0.0001) return "< 0.0001";
  return p < 0.01 ? p.toFixed(4) : p.toFixed(2);
}

function percent(value) {
  return `${(100 * value).toFixed(1)} %`;
}

function row(name, mean) {
  const doubt = mean.doubt(CONFIDENCE);
  const known = Number.isFinite(doubt);
  if (mean.count === 0) return make("div", {}, make("dt", {}, name), make("dd", {}, none()));
  const value = make("dd", {}, percent(mean.mean));
  if (known) value.append(" ", make("small", {}, `± ${(100 * doubt).toFixed(1)}`));
  value.append(make("small", {}, ` of ${counted(mean.count, "drop")}`));
  const parts = [make("dt", {}, name), value];
  if (known) parts.push(make("dd", { class: "ruler-box" }, ruler(mean.mean, doubt)));
  return make("div", {}, ...parts);
}

function none() {
  return make("small", {}, "no drops yet");
}

/** From nothing on the left to twice the stake on the right. */
function ruler(mean, doubt) {
  const place = (value) => `${Math.max(0, Math.min(100, 50 * value)).toFixed(2)}%`;
  const bar = make("span", { class: "ruler-bar" });
  bar.style.left = place(mean - doubt);
  bar.style.right = `calc(100% - ${place(mean + doubt)})`;
  const middle = make("span", { class: "ruler-middle" });
  middle.style.left = place(mean);
  return make("span", { class: "ruler", "aria-hidden": "true" }, bar, middle);
}
