// Drops whose end is not told beforehand: of shared links, and of the day. Pure.

import { t } from "../texts/text.js";


const DAY_BOARD = "triangle-16";

/**
 * The drop of the day: one for everybody, named by the day in Greenwich.
 * @param {Date} now
 * @returns {{board: string, seed: string}}
 */
export function dropOfDay(now) {
  return { board: DAY_BOARD, seed: now.toISOString().slice(0, 10).replaceAll("-", "") };
}

/**
 * @param {number | null} guess the bin that a player named, if any
 * @param {number | null} bin where the ball landed; null: in none
 * @returns {string} what the player hears
 */
export function guessWords(guess, bin) {
  if (guess === null || bin === null) return "";
  const off = Math.abs(guess - bin);
  return off === 0 ? ` ${t("replay.right")}` : ` ${t("replay.wrong", { n: off, guess })}`;
}
