// Parses amounts as players type them, with a comma or a point. Pure.

import { mostStake } from "../../model/payout.js";
import { MINOR_UNITS } from "../../model/player/account.js";
import { number, t } from "../../texts/text.js";
import { readNumber } from "../../util/number-text.js";

export const LEAST_STAKE = 0.01;
export const MOST_STAKE = 1_000_000;
export const MOST_BALLS = 1_000_000; // of an auto-drop with an end
export const FACTORS = { least: 0.1, most: 100 }; // of a stake, after a win or a loss
const CLIP = 12; // characters of an invalid value that are shown

/** @param {string} text @returns {number | null} rounded to hundredths; null if invalid */
export function readAmount(text) {
  const bare = ungrouped(text.trim());
  const amount = /^[\d.,]+$/.test(bare) ? readNumber(bare) : null; // without a sign or an exponent
  return amount === null ? null : Math.round(100 * amount) / 100;
}

/** @param {string} text @returns {string} without the thousands separators of the page's language, if it has them right */
function ungrouped(text) {
  const group = number(11111).replaceAll(number(1), "");
  const grouped = new RegExp(`^[1-9]\\d{0,2}(?:\\${group}\\d{3})+(?:[.,]\\d*)?$`);
  return grouped.test(text) ? text.split(group).join("") : text;
}

/** @param {number[] | null} multipliers of the board, null before it is known @returns {number} the largest stake */
export function mostCredits(multipliers) {
  return multipliers ? Math.min(MOST_STAKE, mostStake(multipliers) / MINOR_UNITS) : MOST_STAKE;
}

/** @param {string} text @param {number} [most] @returns {number | null} null if the server would refuse the stake */
export function readStake(text, most = MOST_STAKE) {
  const stake = readAmount(text);
  return stake !== null && stake >= LEAST_STAKE && stake <= most ? stake : null;
}

/** @param {number} stake @param {number} [most] @returns {number} the nearest valid stake, rounded down to hundredths */
export function allowedStake(stake, most = MOST_STAKE) {
  return Math.max(LEAST_STAKE, Math.min(most, Math.floor(100 * stake + 1e-6) / 100));
}

/** @param {number} amount @returns {string} in the page's language, without separators of thousands */
export function typed(amount) {
  return number(amount, { maximumFractionDigits: 2, useGrouping: false });
}

/** @param {string} text @returns {number | null} balls; null if invalid */
export function readCount(text) {
  const count = readAmount(text);
  return count !== null && Number.isInteger(count) && count >= 1 && count <= MOST_BALLS ? count : null;
}

/** @param {string} text @returns {number | null} null if invalid */
export function readFactor(text) {
  const factor = readAmount(text);
  return factor !== null && factor >= FACTORS.least && factor <= FACTORS.most ? factor : null;
}

/** @param {string} text the invalid value @param {string} rule which ones are valid @returns {string} */
export function faultOf(text, rule) {
  const fault = text ? t("fault.typed", { typed: text.slice(0, CLIP) }) : t("fault.empty");
  return `${fault} ${rule}`;
}
