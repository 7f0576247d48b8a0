// The account as this browser keeps it, for all its tabs: read again before each change.

import { applied, newAccount, openDrops } from "../../model/player/account.js";

/** @import { Account, AccountEvent, OpenDrop } from "../../model/player/account.js" */

const KEY = "plinko.account.1";
const MARK_KEY = "plinko.mark.1";
const MARK_BYTES = 16; // nobody guesses them

/** One player's credits. */
export class Wallet {
  #text = "";
  #account = newAccount();

  /** @param {Pick<Storage, "getItem" | "setItem">} storage */
  constructor(storage) {
    this.storage = storage;
  }

  /** @returns {Account} as the last of all tabs left it */
  get account() {
    const text = this.storage.getItem(KEY) ?? "";
    if (text !== this.#text) {
      this.#text = text;
      this.#account = { ...newAccount(), ...(text && JSON.parse(text)) };
    }
    return this.#account;
  }

  /**
   * @param {...AccountEvent} events
   * @returns {boolean} whether one of them was news
   */
  apply(...events) {
    const before = this.account;
    const after = events.reduce(applied, before);
    if (after === before) return false;
    this.#account = after;
    this.#text = JSON.stringify(after);
    this.storage.setItem(KEY, this.#text);
    return true;
  }

  /** @returns {OpenDrop[]} drops whose end has not been heard of */
  get open() {
    return openDrops(this.account);
  }

  /** @returns {string} hexadecimal: the anonymous ID by which the server finds this player's drops */
  get mark() {
    return this.storage.getItem(MARK_KEY) ?? this.renewMark();
  }

  /** Makes another; drops under the one before are found only by that one. @returns {string} */
  renewMark() {
    const bytes = crypto.getRandomValues(new Uint8Array(MARK_BYTES));
    const value = Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
    this.storage.setItem(MARK_KEY, value);
    return value;
  }
}
