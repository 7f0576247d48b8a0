// What counts as a seed, and what to say when it does not. Pure.

import { t } from "../texts/text.js";

export const MAX_SEED = 2n ** 64n - 1n;

/**
 * @typedef {{ok: true, seed: string | null} | {ok: false, message: string}} SeedReading
 * seed is a decimal string (JSON numbers lose the last digits), null when the field is empty.
 */

/** @param {string} text as typed @returns {SeedReading} */
export function readSeed(text) {
  const typed = text.trim();
  if (typed === "") return { ok: true, seed: null };
  if (!/^[0-9]+$/.test(typed)) {
    return { ok: false, message: `${t("seed.none", { typed: clip(typed) })} ${RULE}` };
  }
  // The length check keeps a pasted novel of digits away from BigInt.
  const digits = typed.replace(/^0+(?=\d)/, "");
  if (digits.length > 20 || BigInt(digits) > MAX_SEED) {
    return { ok: false, message: `${t("seed.large", { typed: clip(digits) })} ${RULE}` };
  }
  return { ok: true, seed: digits };
}

/** @param {string} seed decimal @returns {string} the next one; 0 comes after the last */
export function seedAfter(seed) {
  return String((BigInt(seed) + 1n) & MAX_SEED);
}

const RULE = t("seed.rule", { most: String(MAX_SEED) });

/** @param {string} text */
function clip(text) {
  return text.length > 24 ? `${text.slice(0, 24)}…` : text;
}
