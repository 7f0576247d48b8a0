// A player and a payout as lists show them: the mark of a colour, a name, and a bin's prize or multiplier.

import { labelOf } from "../../model/board.js";
import { coloursOf, prizeOf } from "../../paint/prizes.js";
import { t } from "../../texts/text.js";
import { make } from "../../util/dom.js";

/** @import { Board } from "../../model/board.js" */
/** @import { Owner } from "../../model/table/visitors.js" */
/** @import { Theme } from "../../paint/theme.js" */

/** @param {string} colour #rrggbb */
export function swatch(colour) {
  const dot = make("i", { class: "swatch" });
  dot.style.background = colour;
  return dot;
}

/** @param {Owner | null} owner @returns {string} */
export function called(owner) {
  if (owner?.name) return owner.name;
  return owner?.visitor === undefined ? t("visitors.someone") : t("visitors.guest", { n: owner.visitor });
}

/**
 * @param {Theme} theme @param {Board | null} board @param {number | null} bin @param {number} score
 * @returns {HTMLElement} the prize or the multiplier, in its bin's colour
 */
export function paidMark(theme, board, bin, score) {
  if (bin === null) return make("span", { class: "paid" }, t("play.void"));
  const paid = make("span", { class: "paid" }, make("bdi", {}, prizeOf(board, bin, score)));
  const { fill, ink } = coloursOf(board && labelOf(board, bin), theme.payout(score));
  Object.assign(paid.style, { background: fill, color: ink });
  return paid;
}
