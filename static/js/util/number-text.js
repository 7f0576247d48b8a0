// Reads numbers as visitors type them in any field of any page: with a decimal comma or point, whatever the page's
// language. Digits stay text, so that none is lost. Pure.

import { t } from "../texts/text.js";

const NUMBER = /^([+\-−]?)(\d*)(?:[.,](\d*))?(?:[eE]([+\-−]?\d+))?$/;

/** @param {string} text as typed @returns {string | null} the number with a point, as JSON and REST take it; null if invalid */
export function decimalOf(text) {
  const [, sign, whole, part = "", exponent = ""] = NUMBER.exec(text.trim()) ?? [];
  if (!whole && !part) return null;
  const digits = `${sign === "-" || sign === "−" ? "-" : ""}${whole || "0"}${part && `.${part}`}`;
  const number = digits + (exponent && `e${exponent.replace("−", "-").replace("+", "")}`);
  return Number.isFinite(Number(number)) ? number : null;
}

/** @param {string} text as typed @returns {number | null} null if invalid */
export function readNumber(text) {
  const number = decimalOf(text);
  return number === null ? null : Number(number);
}

/** @param {string} text as typed @returns {string} says that it is not a number */
export function noNumber(text) {
  return t("page.no-number", { typed: text.trim().slice(0, 24) });
}
