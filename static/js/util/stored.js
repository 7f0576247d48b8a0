// Reads JSON that this page has stored. What is damaged, by another program or a crash, counts as absent. Pure.

/** @typedef {Pick<Storage, "getItem">} Readable */

/** @param {unknown} value @returns {value is Record<string, unknown>} */
export const isRecord = (value) => typeof value === "object" && value !== null && !Array.isArray(value);

/**
 * @template T
 * @param {string | null} text
 * @param {(value: unknown) => value is T} isRight checks what the page relies on
 * @returns {T | null} null if the text is absent, is no JSON or is of another form
 */
export function parseStored(text, isRight) {
  if (text === null) return null;
  try {
    const value = JSON.parse(text);
    return isRight(value) ? value : null;
  } catch (error) {
    if (!(error instanceof SyntaxError)) throw error;
    return null;
  }
}

/**
 * @template T
 * @param {Readable} storage @param {string} key
 * @param {(value: unknown) => value is T} isRight
 * @returns {T | null}
 */
export function readStored(storage, key, isRight) {
  return parseStored(storage.getItem(key), isRight);
}
