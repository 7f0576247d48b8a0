// Stores the tokens of this browser's fair sessions; the server exports a session only with its token.

const KEY = "plinko.tokens.1";
const KEPT = 200; // the latest sessions

/** @param {Pick<Storage, "getItem" | "setItem">} storage @returns {[string, string][]} session and token */
const kept = (storage) => JSON.parse(storage.getItem(KEY) ?? "[]");

/**
 * @param {Pick<Storage, "getItem" | "setItem">} storage
 * @param {string} session
 * @param {string} token sent by the server when the session began
 */
export function keepToken(storage, session, token) {
  storage.setItem(KEY, JSON.stringify([...kept(storage), [session, token]].slice(-KEPT)));
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
