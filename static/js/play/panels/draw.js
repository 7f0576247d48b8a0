// The odds of a room with a draw: its bins with their multipliers and exact probabilities.

import { labelOf } from "../../model/board.js";
import { drawOdds } from "../../model/draw.js";
import { t } from "../../texts/text.js";
import { byId, make } from "../../util/dom.js";
import { multiplier } from "../../util/format.js";

/** @import { Game } from "../game.js" */

/** Hidden in rooms without a draw. @param {Game} game */
export function showDraw(game) {
  game.on("table", ({ hello: { board, draw } }) => {
    byId("draw").hidden = draw === undefined;
    byId("fair-words").textContent = t(draw ? "draw.fair" : "fair.words");
    const rows = draw ? drawOdds(draw.weights) : [];
    byId("draw-odds").replaceChildren(...rows.map(({ bin, words }) => make("li", {},
      make("span", {}, labelOf(board, bin)?.text ?? t("draw.bin", { n: bin + 1 })),
      make("span", {}, multiplier(board.bins.multipliers[bin])),
      make("b", {}, words))));
  });
}
