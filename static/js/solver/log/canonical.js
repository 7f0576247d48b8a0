// Canonical JSON (RFC 8785), the text that digests cover, with whole numbers of any size exact. Pure.

const STRING_OR_NUMBER = /"(?:[^"\\]|\\.)*"|-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?/g;
const LARGE = /^-?\d{16,}$/;
const MARK = "\u0000whole:"; // no text in a record begins with this

/**
 * Parses JSON text. A whole number that a double would round becomes a BigInt.
 * @param {string} text throws a SyntaxError if it is not JSON
 * @returns {unknown}
 */
export function readJson(text) {
  const marked = text.replace(STRING_OR_NUMBER, (token) =>
    (LARGE.test(token) ? JSON.stringify(MARK + token) : token));
  return JSON.parse(marked, (_, value) =>
    (typeof value === "string" && value.startsWith(MARK) ? wholeNumber(value.slice(MARK.length)) : value));
}

/** @param {string} digits @returns {number | bigint} */
function wholeNumber(digits) {
  return Number.isSafeInteger(Number(digits)) ? Number(digits) : BigInt(digits);
}

/** @param {unknown} value of JSON @returns {string} */
export function canonical(value) {
  if (typeof value === "bigint") return String(value);
  if (Array.isArray(value)) return `[${value.map(canonical).join(",")}]`;
  if (typeof value !== "object" || value === null) return JSON.stringify(value);
  const members = Object.entries(value).sort(([one], [other]) => (one < other ? -1 : 1));
  return `{${members.map(([name, part]) => `${JSON.stringify(name)}:${canonical(part)}`).join(",")}}`;
}
