// Test drops of the edited board: a worker computes them, and a histogram counts them.

import { Histogram } from "../instruments/histogram.js";
import { messageOf } from "../net/api.js";
import { Batch } from "../solver/many/batch.js";
import { t } from "../texts/text.js";
import { byId } from "../util/dom.js";
import { percent, seconds } from "../util/format.js";

/** @import { Board } from "../model/board.js" */
/** @import { Theme } from "../paint/theme.js" */
/** @import { Tally } from "../solver/many/batch.js" */

/** The histogram, with an alternative text about test drops. */
class TestHistogram extends Histogram {
  /** @param {number} total @returns {string} */
  describe(total) {
    if (total === 0) return t("editor.histogram-none");
    const bins = this.counts.map((count, bin) => t("lab.histogram-bin", { bin, count }));
    return t("editor.histogram", { n: total, bins: bins.join(", ") });
  }
}

/** The button, the tray and its figures. Each press drops the next seeds, or cancels the running batch. */
export class TestDrops {
  /** @type {Tally | null} */
  #tally = null;
  /** @type {Batch | null} */
  #batch = null;

  /** @param {Theme} theme @param {() => Board} board @param {(text: string) => void} say */
  constructor(theme, board, say) {
    this.histogram = new TestHistogram(byId("histogram", HTMLCanvasElement), theme);
    this.board = board;
    this.say = say;
    theme.onChange(() => this.histogram.draw());
    this.button = byId("test", HTMLButtonElement);
    this.progress = byId("test-progress", HTMLProgressElement);
    this.button.addEventListener("click", () => {
      if (this.#batch) this.#batch.cancel();
      else this.#run();
    });
  }

  /** Discards the counts after a change of the board. */
  reset() {
    const board = this.board();
    this.#batch?.cancel();
    this.#tally = null;
    this.histogram.setBoard(board, board.bins.multipliers.map(() => 0), null);
    this.#show();
  }

  async #run() {
    const board = this.board();
    const before = this.#tally;
    const drops = Number(byId("test-count", HTMLSelectElement).value);
    const batch = new Batch({ board, first: String(before?.drops ?? 0), drops }, (tally) => {
      if (board === this.board()) this.#count(added(before, tally), tally.drops / drops);
    });
    this.#running(batch);
    try {
      const tally = await batch.done;
      if (board !== this.board()) return;
      const short = (tally?.drops ?? 0) < drops;
      const numbers = `${byId("tray-count").textContent}: ${byId("tray-numbers").textContent}.`;
      this.say([short ? t("editor.cancelled") : "", tally ? numbers : ""].join(" ").trim());
    } catch (error) {
      this.say(t("editor.test-failed", { why: messageOf(error) }));
    } finally {
      if (this.#batch === batch) this.#running(null);
    }
  }

  /** @param {Tally} tally @param {number} share of this batch that is done */
  #count(tally, share) {
    this.#tally = tally;
    this.progress.value = share;
    this.histogram.setBoard(this.board(), tally.histogram, null);
    this.#show();
  }

  /** @param {Batch | null} batch */
  #running(batch) {
    this.#batch = batch;
    this.button.textContent = batch ? t("editor.cancel") : t("editor.test");
    this.progress.hidden = batch === null;
    this.progress.value = 0;
  }

  #show() {
    const tally = this.#tally;
    byId("tray-count").textContent = tally ? t("editor.test-drops", { n: tally.drops }) : t("editor.no-test");
    if (!tally) {
      byId("tray-numbers").textContent = "";
      return;
    }
    const pays = this.board().bins.multipliers;
    // The stake of a ball that does not land is returned.
    const paid = tally.histogram.reduce((sum, count, bin) => sum + count * pays[bin], tally.unsettled);
    const parts = [
      t("editor.return", { share: percent(paid / tally.drops) }),
      t("editor.mean-fall", { time: seconds(tally.time / tally.drops) }),
      ...(tally.unsettled ? [t("editor.unsettled", { n: tally.unsettled })] : []),
    ];
    byId("tray-numbers").textContent = parts.join(", ");
  }
}

/** @param {Tally | null} tally @param {Tally} more @returns {Tally} */
function added(tally, more) {
  if (!tally) return more;
  return {
    drops: tally.drops + more.drops,
    histogram: tally.histogram.map((count, bin) => count + more.histogram[bin]),
    unsettled: tally.unsettled + more.unsettled,
    time: tally.time + more.time,
  };
}
