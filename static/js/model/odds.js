// Average return and chance of the top award for an aim, from counted drops. Pure.

import { t } from "../texts/text.js";
import { multiplier, percent } from "../util/format.js";
import { Mean } from "./statistics.js";

/**
 * @typedef {{multiplier: number, chance: number}} Award
 * @typedef {{aim: number | null, drops: number, return: number, doubt: number, chances: number[], awards: Award[],
 *   measured?: boolean}} Odds for one aim; doubt: half the width of the 95 % interval of
 *   the return; measured: whether this page counted them, instead of the published record
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

/** @param {Odds} odds @returns {string} a sentence for the player */
export function oddsWords({ return: returned, awards, measured = false }) {
  const [{ multiplier: top, chance }] = awards;
  const told = { returned: percent(returned, measured ? 0 : 2), top: multiplier(top) };
  return chance > 0 ? t("play.odds", { ...told, drops: Math.round(1 / chance) }) : t("play.odds-never", told);
}

/**
 * Odds from drops that this page computed.
 * @param {{drops: number, histogram: number[], unsettled: number}} tally
 * @param {number[]} multipliers
 * @returns {Odds}
 */
export function measuredOdds({ drops, histogram, unsettled }, multipliers) {
  const scores = new Mean();
  histogram.forEach((count, bin) => scores.add(multipliers[bin], count));
  scores.add(1, unsettled); // the stake of a void drop is returned
  const top = Math.max(...multipliers);
  const hits = histogram.reduce((sum, count, bin) => sum + (multipliers[bin] === top ? count : 0), 0);
  return {
    aim: null, drops, measured: true, return: scores.mean, doubt: scores.doubt(0.95),
    chances: histogram.map((count) => count / drops), awards: [{ multiplier: top, chance: hits / drops }],
  };
}
