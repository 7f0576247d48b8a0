// What a drop gives back on average, and how often the top award comes, from the aim chosen. Pure.

/** @import { Odds } from "../net/replies.js" */

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
  const once = chance > 0 ? `comes once in ${Math.round(1 / chance).toLocaleString("en")} drops` : "was never seen";
  return `Gives back ${percent(returned)} ± ${percent(doubt)} on average; ${multiplier}× ${once}.`;
}

/** @param {number} value */
const percent = (value) => `${(100 * value).toFixed(1)} %`;
