// Stores the tokens of this browser's fair sessions; the server exports a session only with its token. Each token has an
// entry of its own, so that tabs that store tokens at the same time do not take each other's away.

import { readStored } from "../util/stored.js";

/** @typedef {Pick<Storage, "getItem" | "setItem" | "removeItem">} Tokens */

const KEY = "plinko.token.";
const SESSIONS = "plinko.tokens.2"; // the sessions whose tokens are stored, oldest first
const FORMER = "plinko.tokens.1"; // of release 1.0: pairs of session and token
const KEPT = 200;

/** @param {unknown} value @returns {value is string[]} */
const isSessions = (value) => Array.isArray(value) && value.every((session) => typeof session === "string");

/** @param {unknown} value @returns {value is string[][]} */
const isFormer = (value) => Array.isArray(value) && value.every(isSessions);

/** @param {Tokens} storage @param {string} session @param {string} token sent by the server when the session began */
export function keepToken(storage, session, token) {
  storage.setItem(KEY + session, token);
  const all = [...(readStored(storage, SESSIONS, isSessions) ?? []), session];
  for (const old of all.slice(0, -KEPT)) storage.removeItem(KEY + old);
  storage.setItem(SESSIONS, JSON.stringify(all.slice(-KEPT)));
}

/** @param {Tokens} storage @param {string} session @returns {string | undefined} the token, if this browser has it */
export function tokenOf(storage, session) {
  const former = () => readStored(storage, FORMER, isFormer)?.find(([id]) => id === session)?.[1];
  return storage.getItem(KEY + session) ?? former();
}

/** The options for a request about a session. @param {Tokens} storage @param {string} session @returns {RequestInit} */
export function showingToken(storage, session) {
  const token = tokenOf(storage, session);
  return token ? { headers: { accept: "application/json", authorization: `Bearer ${token}` } } : {};
}
