// The stage's tray: landed balls in their owners' colours, as a pile or as bars, and the expected counts.

import { Colours } from "../instruments/colours.js";
import { Histogram } from "../instruments/histogram.js";
import { LARGE_DISCS } from "../instruments/pile/columns.js";
import { openPile } from "../instruments/pile/pile.js";
import { swatchOf } from "../model/table/visitors.js";
import { t } from "../texts/text.js";
import { byId } from "../util/dom.js";
import { expectedOn } from "./expected.js";

/** @import { Hello } from "../model/messages.js" */
/** @import { Theme } from "../paint/theme.js" */
/** @import { Store } from "../play/store.js" */
/** @import { StageOptions } from "./options.js" */

const AGAIN_MS = 30_000; // until the next request, if the expected counts could not be loaded

/** The tray below the board. */
export class StageTray {
  #digest = "";

  /** @param {StageOptions} options @param {Theme} theme @param {Store} news */
  constructor({ tray, expected }, theme, news) {
    this.expected = expected;
    this.news = news;
    this.histogram = new Histogram(byId("histogram", HTMLCanvasElement), theme, new Colours());
    byId("tray").hidden = false;
    news.on("hit", ({ bin, entry, owner }) => {
      this.histogram.add(bin, entry, owner ? swatchOf(owner) : undefined);
      news.tell("picture", null);
    });
    theme.onChange(() => this.histogram.draw());
    if (tray === "pile") void this.#heapUp(theme);
  }

  /** @param {Theme} theme */
  async #heapUp(theme) {
    // A browser that cannot compute the pile shows bars.
    const pile = await openPile(theme, LARGE_DISCS).catch(() => null);
    this.histogram.setPile(pile);
    this.news.tell("picture", null);
  }

  /** @param {Hello} hello */
  setTable(hello) {
    const { board, board_digest: digest, stats } = hello;
    const other = this.#digest !== digest;
    this.histogram.setBoard(board, stats.histogram, other ? null : this.histogram.expected);
    if (!other) return;
    this.#digest = digest;
    byId("tray-key").hidden = true;
    if (this.expected) void this.#expect(hello);
  }

  /** @param {Hello} hello */
  async #expect(hello) {
    if (hello.board_digest !== this.#digest || !this.expected) return;
    const expected = await expectedOn(hello, this.expected).catch(() => null);
    if (hello.board_digest !== this.#digest) return;
    if (!expected) {
      window.setTimeout(() => void this.#expect(hello), AGAIN_MS);
      return;
    }
    byId("tray-key").textContent = t("stage.expected", { label: expected.label });
    byId("tray-key").hidden = false;
    this.histogram.setExpected(expected);
    this.news.tell("picture", null);
  }

  /**
   * @param {number} nowMs @param {boolean} still whether motion is reduced
   * @returns {boolean} whether to call it again soon
   */
  show(nowMs, still) {
    this.histogram.refresh(nowMs, still);
    const { words } = this.histogram;
    if (byId("tray-count").textContent !== words) byId("tray-count").textContent = words;
    return this.histogram.pending;
  }
}
