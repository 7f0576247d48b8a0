// Stores the tokens of this browser's fair sessions; the server exports a session only with its token.

import { readStored } from "../util/stored.js";

const KEY = "plinko.tokens.1";
const KEPT = 200; // the latest sessions

/** @param {Pick<Storage, "getItem" | "setItem">} storage @returns {[string, string][]} session and token */
const kept = (storage) => readStored(storage, KEY, isPairs) ?? [];

/** @param {unknown} value @returns {value is [string, string][]} */
function isPairs(value) {
  return Array.isArray(value) && value.every((pair) =>
    Array.isArray(pair) && pair.length === 2 && pair.every((part) => typeof part === "string"));
}

/**
 * Stores a token, unless it is stored already. Another tab's write may take it away: repeat this while the session goes on.
 * @param {Pick<Storage, "getItem" | "setItem">} storage
 * @param {string} session
 * @param {string} token sent by the server when the session began
 */
export function keepToken(storage, session, token) {
  const all = kept(storage);
  if (all.some(([id]) => id === session)) return;
  storage.setItem(KEY, JSON.stringify([...all, [session, token]].slice(-KEPT)));
}

/**
 * The options for a request about a session: the token, if this browser has it.
 * @param {Pick<Storage, "getItem" | "setItem">} storage
 * @param {string} session
 * @returns {RequestInit}
 */
export function showingToken(storage, session) {
  const token = kept(storage).find(([id]) => id === session)?.[1];
  return token === undefined ? {} : { headers: { accept: "application/json", authorization: `Bearer ${token}` } };
}
