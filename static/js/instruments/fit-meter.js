// Judges the table's histogram and the returns: what chance allows, in numbers.

import { fitTest, Mean, sameTest } from "../model/statistics.js";
import { messageOf } from "../net/api.js";
import { t } from "../texts/text.js";
import { byId, make, parentOf, radiosOf } from "../util/dom.js";
import { fixed, percent } from "../util/format.js";
import { measure, SAMPLE } from "./measure.js";

/** @import { Hello } from "../model/messages.js" */
/** @import { Odds } from "../model/odds.js" */
/** @import { Board } from "../model/board.js" */
/** @import { Expectation } from "./histogram.js" */

const CONFIDENCE = 0.95;
const TELL_MS = 500;
const UNLIKELY = 0.01;

/** @typedef {Expectation & {counts?: number[]}} Expected counts: of the sample it was measured in */

/** The fit and the returns; `onExpected(expected)` gives what the histogram is compared with. */
export class FitMeter {
  /** @type {Expected | null} */
  expected = null;
  #told = "";
  #toldMs = 0;
  #waiting = "";
  /** @type {Map<string, Expected>} by the board's digest */
  #measured = new Map();
  #digest = "";
  #fresh = true; // nobody has chosen yet what this board is compared with
  /** @type {Board | null} */
  #board = null;
  /** @type {Expected | null} by the landings of record, from the aim chosen */
  #record = null;

  /** @param {(expected: Expected | null) => void} onExpected @param {(text: string) => void} say */
  constructor(onExpected, say) {
    this.onExpected = onExpected;
    this.say = say;
    this.choices = radiosOf("against");
    for (const choice of this.choices) choice.addEventListener("change", () => this.#choose());
  }

  /** @param {Pick<Hello, "board" | "board_digest">} hello */
  setTable({ board, board_digest: digest }) {
    // A line that came back finds the choice as it was made.
    if (digest === this.#digest) return;
    this.#board = board;
    this.#digest = digest;
    this.#record = null;
    this.#fresh = true;
    this.#take(null);
  }

  /**
   * @param {Odds | null} odds from the aim chosen, where such are known of this board
   * @param {boolean} seen whether anyone looks at the panel
   */
  setRecord(odds, seen) {
    const label = t(odds?.measured ? "lab.label-measured" : "lab.label-counted", { n: odds?.drops ?? 0 });
    this.#record = odds && { label, chances: odds.chances };
    const [record, measured] = this.choices;
    record.disabled = odds === null;
    if (this.#fresh || odds === null) (odds === null ? measured : record).checked = true;
    this.#fresh = false;
    this.#choose(seen);
  }

  /** @param {boolean} asked only then is the server made to work for it */
  async #choose(asked = true) {
    const measured = this.choices.some(({ checked, value }) => checked && value === "measured");
    const digest = this.#digest;
    const known = this.#measured.get(digest);
    if (!measured) this.#take(this.#record);
    else if (known) this.#take(known);
    else if (!asked) this.#take(null);
    else await this.#measure(digest);
  }

  /** @param {string} digest */
  async #measure(digest) {
    this.#waiting = t("lab.measuring", { n: SAMPLE });
    this.#take(null);
    try {
      // One board is kept: a new one is measured anew in a moment.
      const expected = await measure(/** @type {Board} */ (this.#board));
      this.#measured = new Map([[digest, expected]]);
      if (digest === this.#digest) this.#take(expected);
    } catch (error) {
      this.#waiting = t("lab.measure-failed", { why: messageOf(error) });
      this.say(this.#waiting);
      this.#take(null);
    }
  }

  /** @param {Expected | null} expected */
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
   * @param {number} nowMs
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

  /** @param {number[]} counts */
  #showFit(counts) {
    const total = counts.reduce((sum, count) => sum + count, 0);
    const { expected } = this;
    const fit = expected && judge(counts, expected);
    const reading = byId("fit-p");
    reading.textContent = fit ? `p = ${probability(fit.p)}` : "–";
    parentOf(reading).dataset.tone = fit && fit.p < UNLIKELY ? "bad" : "";
    if (!expected) {
      byId("fit-note").textContent = this.#waiting;
    } else if (!fit) {
      byId("fit-note").textContent = t("lab.too-few", { n: total });
    } else {
      const told = { g: fixed(fit.statistic, 1), n: fit.freedom, drops: t("count.drop", { n: total }) };
      byId("fit-note").textContent = `${verdict(fit.p)} ${t("lab.fit-note", told)}`;
    }
  }

  /** @param {number[]} counts @param {Mean} own */
  #showReturns(counts, own) {
    if (!this.#board) return;
    const { multipliers } = this.#board.bins;
    const table = new Mean();
    counts.forEach((count, bin) => table.add(multipliers[bin], count));
    byId("returns").replaceChildren(row(t("lab.yours"), own), row(t("lab.tables"), table));
    const due = this.expected?.chances.reduce((sum, chance, bin) => sum + chance * multipliers[bin], 0);
    byId("returns-note").textContent = due === undefined || !this.expected
      ? ""
      : t("lab.expected", { label: this.expected.label, due: percent(due) });
  }
}

/** @param {number[]} counts @param {Expected} expected */
function judge(counts, { chances, counts: sample }) {
  return sample ? sameTest(counts, sample) : fitTest(counts, chances);
}

/** @param {number} p */
function verdict(p) {
  if (p < UNLIKELY) return t("lab.unlikely");
  return t("lab.likely");
}

/** @param {number} p @returns {string} two digits that tell; tiny ones as a bound */
function probability(p) {
  if (p < 0.0001) return `< ${fixed(0.0001, 4)}`;
  return fixed(p, p < 0.01 ? 4 : 2);
}

/** @param {string} name @param {Mean} mean */
function row(name, mean) {
  const doubt = mean.doubt(CONFIDENCE);
  const known = Number.isFinite(doubt);
  if (mean.count === 0) return make("div", {}, make("dt", {}, name), make("dd", {}, none()));
  const value = make("dd", {}, percent(mean.mean));
  if (known) value.append(" ", make("small", {}, `± ${fixed(100 * doubt, 1)}`));
  value.append(" ", make("small", {}, t("lab.of-drops", { n: mean.count })));
  const parts = [make("dt", {}, name), value];
  if (known) parts.push(make("dd", { class: "ruler-box" }, ruler(mean.mean, doubt)));
  return make("div", {}, ...parts);
}

function none() {
  return make("small", {}, t("lab.no-drops"));
}

/**
 * From nothing on the left to twice the stake on the right.
 * @param {number} mean
 * @param {number} doubt
 */
function ruler(mean, doubt) {
  /** @param {number} value */
  const place = (value) => `${Math.max(0, Math.min(100, 50 * value)).toFixed(2)}%`;
  const bar = make("span", { class: "ruler-bar" });
  bar.style.left = place(mean - doubt);
  bar.style.right = `calc(100% - ${place(mean + doubt)})`;
  const middle = make("span", { class: "ruler-middle" });
  middle.style.left = place(mean);
  return make("span", { class: "ruler", "aria-hidden": "true" }, bar, middle);
}
