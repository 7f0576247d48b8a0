// What a bin pays for the present stake, and its chance; and the list of all bins, for players who do not point at the board.

import { labelOf } from "../../model/board.js";
import { payoutOf } from "../../model/payout.js";
import { MINOR_UNITS } from "../../model/player/account.js";
import { prizeOf } from "../../paint/prizes.js";
import { t } from "../../texts/text.js";
import { byId, make } from "../../util/dom.js";
import { amount, percent } from "../../util/format.js";

/** @import { Hello } from "../../model/messages.js" */
/** @import { Game } from "../game.js" */

const RARE = 0.01; // below this share the words are "1 of n balls"

/** @param {Game} game @param {Hello} hello of its room @param {number} bin @returns {[string, string]} chance: "" if unknown */
export function binWords(game, { board, draw }, bin) {
  const score = board.bins.multipliers[bin];
  const pays = prizeOf(board, bin, score);
  const paid = amount(payoutOf(Math.round(MINOR_UNITS * game.choice.stake), score) / MINOR_UNITS);
  const total = draw?.weights.reduce((sum, weight) => sum + weight, 0) ?? 1;
  const part = draw ? draw.weights[bin] / total : game.odds?.chances[bin];
  return [game.practice || labelOf(board, bin) ? pays : t("odds.pays", { pays, paid }), chanceWords(part)];
}

/** @param {number | undefined} part @returns {string} */
function chanceWords(part) {
  if (part === undefined) return "";
  if (part === 0) return t("odds.never");
  return part < RARE ? t("odds.rare", { n: Math.round(1 / part) }) : t("odds.share", { share: percent(part) });
}

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
