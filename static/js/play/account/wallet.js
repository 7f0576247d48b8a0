// The account in the browser's storage. All tabs share it, so it is read again before each change.

import { applied, newAccount, openDrops } from "../../model/player/account.js";

/** @import { Account, AccountEvent, OpenDrop } from "../../model/player/account.js" */

const KEY = "plinko.account.1";
const MARK_KEY = "plinko.mark.1";
const MARK_BYTES = 16; // too many to guess

/** One player's credits. */
export class Wallet {
  #text = "";
  #account = newAccount();

  /** @param {Pick<Storage, "getItem" | "setItem">} storage */
  constructor(storage) {
    this.storage = storage;
  }

  /** @returns {Account} as the last tab to change it left it */
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
   * @returns {boolean} whether one of them changed the account
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

  /** @returns {OpenDrop[]} drops whose result is not known yet */
  get open() {
    return openDrops(this.account);
  }

  /** @returns {string} hexadecimal: the anonymous ID by which the server finds this player's drops */
  get mark() {
    return this.storage.getItem(MARK_KEY) ?? this.renewMark();
  }

  /** Makes a new ID. Drops made under the old ID are found only by the old one. @returns {string} */
  renewMark() {
    const bytes = crypto.getRandomValues(new Uint8Array(MARK_BYTES));
    const value = Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
    this.storage.setItem(MARK_KEY, value);
    return value;
  }
}
