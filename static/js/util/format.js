// Formats numbers in the page's language. Pure.

import { number } from "../texts/text.js";

/** @param {number} value a multiplier, e.g. 1.5 @returns {string} "1.5x" */
export function multiplier(value) {
  return `${plain(value)}x`;
}

/** @param {number} value @returns {string} two decimals: "12.50" */
export function amount(value) {
  return fixed(value, 2);
}

/** @param {number} value @returns {string} "+2.50", "−0.50", "0.00" */
export function signed(value) {
  const text = amount(Math.abs(value));
  if (Math.round(100 * value) === 0) return text;
  return value > 0 ? `+${text}` : `−${text}`;
}

/** @param {number} value seconds @returns {string} "3.42 s" */
export function seconds(value) {
  return `${fixed(value, 2)} s`;
}

/** @param {string} seed @returns {string} at most 12 characters, both ends kept */
export function shortSeed(seed) {
  return seed.length > 12 ? `${seed.slice(0, 5)}…${seed.slice(-5)}` : seed;
}

/** @param {number} value @param {number} [decimals] @returns {string} "93.1 %" for 0.931 */
export function percent(value, decimals = 1) {
  return `${fixed(100 * value, decimals)} %`;
}

/** @param {number} value @param {number} decimals @returns {string} "12.500" */
export function fixed(value, decimals) {
  return number(value, { minimumFractionDigits: decimals, maximumFractionDigits: decimals });
}

/** @param {number} value @param {number} digits significant ones @returns {string} "1.5", "0.015" */
export function rounded(value, digits) {
  return number(value, { maximumSignificantDigits: digits, minimumSignificantDigits: digits });
}

/** @param {number} value @returns {string} with at most four decimals, and no trailing zeros */
export function plain(value) {
  return number(value, { maximumFractionDigits: 4 });
}

const SMALL = /** @type {const} */ ([[1e-3, "mm"], [1e-6, "µm"], [1e-9, "nm"], [1e-12, "pm"], [1e-15, "fm"]]);

/** @param {number} metres above 0, below 1 @returns {string} "3.2 mm", "0.11 fm" */
export function metric(metres) {
  const [unit, name] = SMALL.find(([size]) => metres >= size) ?? SMALL[SMALL.length - 1];
  return `${number(metres / unit, { maximumSignificantDigits: 2 })} ${name}`;
}

/** @param {string} text @returns {string} with a capital first letter */
export function capital(text) {
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/** @param {string} text @returns {string} the text, ended by a full stop unless it has an end */
export function withFullStop(text) {
  return /[.!?]$/.test(text) ? text : `${text}.`;
}
