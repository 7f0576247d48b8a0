// Returns the page's texts in its language. For another language the server replaces the English file:
// see app/web/page/release.py.

import texts from "./en.json" with { type: "json" };

/** @typedef {keyof typeof texts} Key */

/** @type {string} the page's language, as BCP 47 names it */
export const language = texts["language"];

/** @type {Intl.PluralRules | null} made when first needed, as loading them takes long */
let plurals = null;
/** @type {Map<string, Intl.NumberFormat>} */
const formats = new Map();

/**
 * Returns a text in the page's language.
 * @param {Key} key
 * @param {Record<string, string | number>} [values] for its placeholders in braces; `n` selects the plural form (CLDR)
 *   of a text that has several
 * @returns {string}
 */
export function t(key, values = {}) {
  /** @type {string | Record<string, string>} */
  const found = texts[key];
  const text = typeof found === "string" ? found : pluralOf(found, Number(values.n));
  return text.replace(/\{(\w+)\}/g, (_, name) => shown(values[name]));
}

/** @param {Record<string, string>} forms @param {number} n */
function pluralOf(forms, n) {
  plurals ??= new Intl.PluralRules(language);
  return forms[plurals.select(n)] ?? forms.other;
}

/** @param {string | number} value */
function shown(value) {
  return typeof value === "number" ? number(value) : value;
}

/**
 * Formats a number in the page's language.
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
