// The list of all bins with payouts and chances, for players who do not point at the board.

import { byId, make } from "../../util/dom.js";
import { binWords } from "./bin-words.js";

/** @import { Game } from "../game.js" */

/** @param {Game} game */
export function showBins(game) {
  const fold = byId("bins-fold", HTMLDetailsElement);
  const show = () => {
    const { hello } = game.room;
    if (!fold.open || !hello) return;
    byId("bins").replaceChildren(...hello.board.bins.multipliers.map((_, bin) => {
      const [pays, chance] = binWords(game, hello, bin);
      return make("li", {}, make("b", {}, pays), make("span", {}, chance));
    }));
  };
  fold.addEventListener("toggle", show);
  for (const kind of /** @type {const} */ (["choice", "odds", "table"])) game.on(kind, show);
}
