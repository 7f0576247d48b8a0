// Canonical JSON (RFC 8785), the text that is signed and hashed.

const LARGEST = 2 ** 53;

/**
 * @param {unknown} value parsed JSON
 * @returns {string} with sorted keys, no spaces, and numbers as JavaScript writes them
 */
export function canonical(value) {
  if (Array.isArray(value)) return `[${value.map(canonical).join(",")}]`;
  if (typeof value === "object" && value !== null) {
    const parts = Object.entries(value).sort(([a], [b]) => (a < b ? -1 : 1));
    return `{${parts.map(([key, part]) => `${JSON.stringify(key)}:${canonical(part)}`).join(",")}}`;
  }
  if (typeof value === "bigint" || (typeof value === "number" && !(Math.abs(value) < LARGEST))) {
    throw new RangeError(`the number ${value} is not within 2^53 of 0`);
  }
  return JSON.stringify(value);
}
