// What the page says, in its language. The server puts another language's texts in the place of the
// English ones: see app/web/page/release.py.

import texts from "./en.json" with { type: "json" };

/** @typedef {keyof typeof texts} Key */

/** @type {string} the page's language, as BCP 47 names it */
export const language = texts["language"];

const plurals = new Intl.PluralRules(language);
/** @type {Map<string, Intl.NumberFormat>} */
const formats = new Map();

/**
 * A text in the page's language.
 * @param {Key} key
 * @param {Record<string, string | number>} [values] for its places in braces; `n` chooses between the
 *   forms of a text that has several, one for each plural category of the language (CLDR)
 * @returns {string}
 */
export function t(key, values = {}) {
  /** @type {string | Record<string, string>} */
  const found = texts[key];
  const text = typeof found === "string" ? found : (found[plurals.select(Number(values.n))] ?? found.other);
  return text.replace(/\{(\w+)\}/g, (_, name) => shown(values[name]));
}

/** @param {string | number} value */
function shown(value) {
  return typeof value === "number" ? number(value) : value;
}

/**
 * A number as the page's language writes it.
 * @param {number} value
 * @param {Intl.NumberFormatOptions} [options]
 * @returns {string}
 */
export function number(value, options = {}) {
  const key = JSON.stringify(options);
  let format = formats.get(key);
  if (!format) {
    format = new Intl.NumberFormat(language, options);
    formats.set(key, format);
  }
  return format.format(value);
}
