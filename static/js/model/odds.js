// What a drop gives back on average, and how often the top award comes, from the aim chosen. Pure.

import { t } from "../texts/text.js";
import { percent, plain } from "../util/format.js";

/**
 * @typedef {{multiplier: number, chance: number}} Award
 * @typedef {{aim: number | null, drops: number, return: number, doubt: number, hit_rate: number,
 *   volatility: number, unsettled: number, chances: number[], awards: Award[]}} Odds from one aim
 */

/**
 * The odds counted nearest to an aim; on a mirrored board one side stands for both.
 * @param {Odds[]} counted the board's own start first
 * @param {number | null} aim m, null for the board's own start
 * @param {number} middle m, the board's own start
 * @returns {Odds | null} null where none were counted
 */
export function oddsAt(counted, aim, middle) {
  if (!counted.length) return null;
  const off = Math.abs((aim ?? middle) - middle);
  /** @param {Odds} odds */
  const away = (odds) => Math.abs(Math.abs((odds.aim ?? middle) - middle) - off);
  return counted.reduce((best, odds) => (away(odds) < away(best) ? odds : best));
}

/** @param {Odds} odds @returns {string} a sentence for those who are about to drop */
export function oddsWords({ return: returned, doubt, awards }) {
  const [{ multiplier, chance }] = awards;
  const told = { returned: percent(returned, 2), doubt: percent(doubt, 2), top: plain(multiplier) };
  return chance > 0 ? t("play.odds", { ...told, drops: Math.round(1 / chance) }) : t("play.odds-never", told);
}
