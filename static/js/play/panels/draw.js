// The odds of a room with a draw: its bins with their multipliers and exact probabilities ("1 in 10,000").

import { labelOf } from "../../model/board.js";
import { language, t } from "../../texts/text.js";
import { byId, make } from "../../util/dom.js";
import { multiplier } from "../../util/format.js";

/** @import { Game } from "../game.js" */

/** Hidden in rooms without a draw. @param {Game} game */
export function showDraw(game) {
  game.on("table", ({ hello: { board, draw } }) => {
    byId("draw").hidden = draw === undefined;
    byId("fair-words").textContent = t(draw ? "draw.fair" : "fair.words");
    const weights = draw?.weights.map(BigInt) ?? [];
    const sum = weights.reduce((total, weight) => total + weight, 0n);
    byId("draw-odds").replaceChildren(...weights.flatMap((weight, bin) => (weight === 0n ? [] : make("li", {},
      make("span", {}, labelOf(board, bin)?.text ?? t("draw.bin", { n: bin + 1 })),
      make("span", {}, multiplier(board.bins.multipliers[bin])),
      make("b", {}, chance(weight, sum))))));
  });
}

/** @param {bigint} weight above 0 @param {bigint} sum @returns {string} "1 in 10,000" */
function chance(weight, sum) {
  const common = divisor(weight, sum);
  return t("draw.chance", { part: shown(weight / common), whole: shown(sum / common) });
}

/** @param {bigint} a @param {bigint} b @returns {bigint} the greatest common divisor */
const divisor = (a, b) => (b === 0n ? a : divisor(b, a % b));

/** @param {bigint} value */
const shown = (value) => value.toLocaleString(language);
