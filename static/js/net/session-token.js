// The tokens of this browser's sessions: only to them does the server export a session.

const KEY = "plinko.tokens.1";
const KEPT = 200; // sessions, the last ones

/** @param {Pick<Storage, "getItem" | "setItem">} storage @returns {[string, string][]} session and token */
const kept = (storage) => JSON.parse(storage.getItem(KEY) ?? "[]");

/**
 * @param {Pick<Storage, "getItem" | "setItem">} storage
 * @param {string} session
 * @param {string} token as the server gave it at the beginning
 */
export function keepToken(storage, session, token) {
  storage.setItem(KEY, JSON.stringify([...kept(storage), [session, token]].slice(-KEPT)));
}

/**
 * What a request about a session needs; nothing of a session of another browser's.
 * @param {Pick<Storage, "getItem" | "setItem">} storage
 * @param {string} session
 * @returns {RequestInit}
 */
export function showingToken(storage, session) {
  const token = kept(storage).find(([id]) => id === session)?.[1];
  return token === undefined ? {} : { headers: { accept: "application/json", authorization: `Bearer ${token}` } };
}
