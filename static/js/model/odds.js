// Average return and chance of the top award for an aim, from counted drops. Pure.

import { t } from "../texts/text.js";
import { multiplier, percent } from "../util/format.js";

/**
 * @typedef {{multiplier: number, chance: number}} Award
 * @typedef {{aim: number | null, drops: number, return: number, doubt: number, chances: number[], awards: Award[]}}
 *   Odds for one aim; doubt: half the width of the 95 % interval of the return
 */

/**
 * The odds for the counted aim nearest to this one. Both sides of the middle count as the same.
 * @param {Odds[]} counted the default start first
 * @param {number | null} aim m, null for the default start
 * @param {number} middle m, the default start
 * @returns {Odds | null} null if none were counted
 */
export function oddsAt(counted, aim, middle) {
  if (!counted.length) return null;
  const off = Math.abs((aim ?? middle) - middle);
  /** @param {Odds} odds */
  const away = (odds) => Math.abs(Math.abs((odds.aim ?? middle) - middle) - off);
  return counted.reduce((best, odds) => (away(odds) < away(best) ? odds : best));
}

/** @param {Odds} odds @returns {{label: string, chances: number[]}} what a tray compares its counts with */
export function recorded({ drops, chances }) {
  return { label: t("lab.label-counted", { n: drops }), chances };
}

/** @param {Odds} odds @returns {string} a sentence for the player */
export function oddsWords({ return: returned, awards }) {
  const [{ multiplier: top, chance }] = awards;
  const told = { returned: percent(returned, 2), top: multiplier(top) };
  return chance > 0 ? t("play.odds", { ...told, drops: Math.round(1 / chance) }) : t("play.odds-never", told);
}
