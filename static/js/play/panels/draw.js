// The odds of a table with a draw: which bins can come, and how often each of them does.

import { labelOf } from "../../model/board.js";
import { drawOdds } from "../../model/draw.js";
import { t } from "../../texts/text.js";
import { byId, make } from "../../util/dom.js";
import { multiplier } from "../../util/format.js";

/** @import { Hello } from "../../model/messages.js" */
/** @import { Game } from "../game.js" */

/** Hidden at tables without a draw. */
export class DrawPanel {
  /** @param {Game} game */
  constructor(game) {
    this.panel = byId("draw");
    this.list = byId("draw-odds");
    game.on("table", ({ hello }) => this.#show(hello));
  }

  /** @param {Hello} hello */
  #show({ board, draw }) {
    this.panel.hidden = draw === undefined;
    byId("fair-words").textContent = t(draw ? "draw.fair" : "fair.words");
    const rows = draw ? drawOdds(draw.weights) : [];
    this.list.replaceChildren(...rows.map(({ bin, words }) => make("li", {},
      make("span", {}, labelOf(board, bin)?.text ?? t("draw.bin", { n: bin + 1 })),
      make("span", {}, multiplier(board.bins.multipliers[bin])),
      make("b", {}, words))));
  }
}
