// Test drops of the board being edited: the server computes many, the histogram counts them.

import { Histogram } from "../instruments/histogram.js";
import { ApiError, postJson } from "../net/api.js";
import { byId } from "../util/dom.js";
import { counted, seconds } from "../util/format.js";

/** @import { Board } from "../model/board.js" */
/** @import { Simulation } from "../net/replies.js" */
/** @import { Theme } from "../paint/theme.js" */

/** The histogram, which speaks of a test instead of a table. */
class TestHistogram extends Histogram {
  /** @param {number} total @returns {string} */
  describe(total) {
    if (total === 0) return "Histogram: no ball was test-dropped yet.";
    const bins = this.counts.map((count, bin) => `bin ${bin}: ${count}`);
    return `Histogram of ${counted(total, "test drop")}. ${bins.join(", ")}.`;
  }
}

/** @typedef {{drops: number, histogram: number[], unsettled: number, time: number}} Tally */

/** The button, the tray and its numbers; each press takes the next seeds. */
export class TestDrops {
  /** @type {Tally | null} */
  #tally = null;

  /** @param {Theme} theme @param {() => Board} board @param {(text: string) => void} say */
  constructor(theme, board, say) {
    this.histogram = new TestHistogram(byId("histogram", HTMLCanvasElement), theme);
    this.board = board;
    this.say = say;
    theme.onChange(() => this.histogram.draw());
    this.button = byId("test", HTMLButtonElement);
    this.button.addEventListener("click", () => this.#run());
  }

  /** The board has changed: what was counted is no longer true of it. */
  reset() {
    const board = this.board();
    this.#tally = null;
    this.histogram.setBoard(board, board.bins.multipliers.map(() => 0), null);
    this.#show();
  }

  async #run() {
    const board = this.board();
    this.button.disabled = true;
    try {
      const drops = Number(byId("test-count", HTMLSelectElement).value);
      const first = this.#tally?.drops ?? 0;
      const reply = await postJson("simulate", { board, drops, seed: String(first) });
      if (board !== this.board()) return;
      this.#tally = added(this.#tally, /** @type {Simulation} */ (reply));
      this.histogram.setBoard(board, this.#tally.histogram, null);
      this.#show();
      this.say(`${byId("tray-count").textContent}: ${byId("tray-numbers").textContent}.`);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.say(`No test: ${error.message}`);
    } finally {
      this.button.disabled = false;
    }
  }

  #show() {
    const tally = this.#tally;
    byId("tray-count").textContent = tally ? counted(tally.drops, "test drop") : "No test yet";
    if (!tally) {
      byId("tray-numbers").textContent = "";
      return;
    }
    const pays = this.board().bins.multipliers;
    // A ball that never settles gives its stake back.
    const paid = tally.histogram.reduce((sum, count, bin) => sum + count * pays[bin], tally.unsettled);
    const parts = [
      `return ${((100 * paid) / tally.drops).toFixed(1)} %`,
      `mean fall ${seconds(tally.time / tally.drops)}`,
      ...(tally.unsettled ? [`${tally.unsettled} unsettled`] : []),
    ];
    byId("tray-numbers").textContent = parts.join(", ");
  }
}

/** @param {Tally | null} tally @param {Simulation} more @returns {Tally} */
function added(tally, { drops, histogram, unsettled, mean_duration: duration }) {
  const had = tally ?? { drops: 0, histogram: histogram.map(() => 0), unsettled: 0, time: 0 };
  return {
    drops: had.drops + drops,
    histogram: had.histogram.map((count, bin) => count + histogram[bin]),
    unsettled: had.unsettled + unsettled,
    time: had.time + duration * drops,
  };
}
