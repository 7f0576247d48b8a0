// Statistics of the room: how well its histogram fits the expected odds, and confidence intervals of the returns.

import { recorded } from "../../model/odds.js";
import { Mean } from "../../model/mean.js";
import { doubtOf, fitTest, sameTest } from "../../model/statistics.js";
import { measure, SAMPLE } from "../../instruments/measure.js";
import { messageOf } from "../../net/api.js";
import { t } from "../../texts/text.js";
import { byId, make, onChoice, parentOf, radiosOf, radioValue } from "../../util/dom.js";
import { fixed, percent } from "../../util/format.js";

/** @import { Hello } from "../../model/messages.js" */
/** @import { Odds } from "../../model/odds.js" */
/** @import { Expectation } from "../../instruments/histogram.js" */
/** @import { Game } from "../game.js" */

const CONFIDENCE = 0.95;
const TELL_MS = 500;
const UNLIKELY = 0.01;

/** @typedef {Expectation & {counts?: number[]}} Expected counts: those of the sample, if it was measured */

/** The fit and the returns. Announces the distribution that the histogram is compared with. */
export class FitMeter {
  /** @type {Expected | null} */
  expected = null;
  #told = "";
  #toldMs = 0;
  #waiting = "";
  /** The last measurement. @type {{digest: string, expected: Expected} | null} */
  #measured = null;
  /** @type {Pick<Hello, "board" | "board_digest"> | null} */
  #table = null;
  #fresh = true; // whether the comparison for this board has not been chosen yet
  /** The recorded odds for the chosen aim. @type {Expected | null} */
  #record = null;

  /** Nothing is measured while this is closed. */
  panel = byId("measure", HTMLDetailsElement);

  /** @param {Game} game */
  constructor(game) {
    this.game = game;
    this.panel.after(make("p", { class: "note" }, make("a", { href: "class.html" }, t("class.door"))));
    onChoice("against", () => this.#choose());
    this.panel.addEventListener("toggle", () => {
      if (this.panel.open) this.#choose();
      game.tell("picture", null);
    });
    game.on("table", ({ hello }) => {
      // A reconnect to the same board keeps the choice.
      if (hello.board_digest === this.#table?.board_digest) return;
      this.#table = hello;
      this.#record = null;
      this.#fresh = true;
      this.#take(null);
    });
    game.on("odds", (odds) => this.#setRecord(odds));
  }

  /** @param {Odds | null} odds for the chosen aim; null if unknown */
  #setRecord(odds) {
    this.#record = odds && recorded(odds);
    const [record, measured] = radiosOf("against");
    record.disabled = odds === null;
    if (this.#fresh || odds === null) (odds === null ? measured : record).checked = true;
    this.#fresh = false;
    this.#choose();
  }

  #choose() {
    if (radioValue("against") !== "measured") this.#take(this.#record);
    else if (this.#measured?.digest === this.#table?.board_digest) this.#take(this.#measured?.expected ?? null);
    else if (!this.panel.open || !this.#table) this.#take(null);
    else void this.#measure(this.#table);
  }

  /** @param {Pick<Hello, "board" | "board_digest">} table */
  async #measure({ board, board_digest: digest }) {
    this.#waiting = t("lab.measuring", { n: SAMPLE });
    this.#take(null);
    try {
      this.#measured = { digest, expected: await measure(board) };
      if (digest === this.#table?.board_digest) this.#take(this.#measured.expected);
    } catch (error) {
      this.#waiting = t("lab.measure-failed", { why: messageOf(error) });
      this.game.say(this.#waiting);
      this.#take(null);
    }
  }

  /** @param {Expected | null} expected */
  #take(expected) {
    this.expected = expected;
    this.#told = "";
    this.game.tell("expected", expected);
  }

  /**
   * @param {number[]} counts by bin
   * @param {number} nowMs
   * @returns {boolean} whether to call it again soon
   */
  show(counts, nowMs) {
    if (!this.panel.open || !this.#table) return false;
    const own = this.game.account.scores;
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
    const { expected } = this;
    const sample = expected?.counts;
    const fit = sample ? sameTest(counts, sample) : expected && fitTest(counts, expected.chances);
    byId("fit-p").textContent = fit ? `p = ${probability(fit.p)}` : "–";
    parentOf(byId("fit-p")).dataset.tone = fit && fit.p < UNLIKELY ? "bad" : "";
    const n = counts.reduce((sum, count) => sum + count, 0);
    byId("fit-note").textContent = !expected ? this.#waiting : !fit ? t("lab.too-few", { n }) : [
      t(fit.p < UNLIKELY ? "lab.unlikely" : "lab.likely"),
      t("lab.fit-note", { g: fixed(fit.statistic, 1), n: fit.freedom, drops: t("count.drop", { n }) }),
    ].join(" ");
  }

  /** @param {number[]} counts @param {Mean} own */
  #showReturns(counts, own) {
    const multipliers = this.#table?.board.bins.multipliers ?? [];
    const table = new Mean();
    counts.forEach((count, bin) => table.add(multipliers[bin], count));
    byId("returns").replaceChildren(row(t("lab.yours"), own), row(t("lab.tables"), table));
    const due = this.expected?.chances.reduce((sum, chance, bin) => sum + chance * multipliers[bin], 0);
    byId("returns-note").textContent = due === undefined || !this.expected
      ? ""
      : t("lab.expected", { label: this.expected.label, due: percent(due, 2) });
  }
}

/** @param {number} p @returns {string} with two significant digits; tiny values as a bound */
function probability(p) {
  if (p < 0.0001) return `< ${fixed(0.0001, 4)}`;
  return fixed(p, p < 0.01 ? 4 : 2);
}

/** @param {string} name @param {Mean} mean */
function row(name, mean) {
  const small = (/** @type {string} */ text) => make("small", {}, text);
  if (mean.count === 0) return make("div", {}, make("dt", {}, name), make("dd", {}, small(t("lab.no-drops"))));
  const doubt = doubtOf(mean, CONFIDENCE);
  const known = Number.isFinite(doubt);
  const value = make("dd", {}, percent(mean.mean));
  if (known) value.append(" ", small(`± ${fixed(100 * doubt, 1)}`));
  value.append(" ", small(t("lab.of-drops", { n: mean.count })));
  return make("div", {}, make("dt", {}, name), value,
    ...(known ? [make("dd", { class: "ruler-box" }, ruler(mean.mean, doubt))] : []));
}

/**
 * Draws a return and its interval on a scale from 0 to twice the stake.
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
