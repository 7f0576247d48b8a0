// The account in the browser's storage, which all tabs share.
//
// A browser cannot read and write its storage in one step: what a tab writes may replace what another tab has written a
// moment before. But an event that the account has already counted changes nothing. So each tab repeats its latest
// events on whatever another tab has stored, as soon as it reads that, and writes the account again if one was missing.
// The last write of several tabs therefore has the events of them all.

import { applied, incompleteSessions, newAccount, openDrops, readAccount } from "../../model/player/account.js";

/** @import { Account, AccountEvent, OpenDrop } from "../../model/player/account.js" */

const KEY = "plinko.account.1";
const MARK_KEY = "plinko.mark.1";
const REPEATED = 1000; // events: far more than a tab has in the moment that a write needs to reach the other tabs
const MARK_BYTES = 16; // too many to guess

/** One player's credits. */
export class Wallet {
  /** The stored text that `#account` was read from or written as. @type {string | null} */
  #text = null;
  #account = newAccount();
  /** This tab's latest events. @type {AccountEvent[]} */
  #latest = [];
  /** Whether the stored account could not be read, so that a new one began. */
  damaged = false;

  /** @param {Pick<Storage, "getItem" | "setItem" | "removeItem">} storage */
  constructor(storage) {
    this.storage = storage;
    const text = storage.getItem(KEY);
    this.damaged = text !== null && readAccount(text) === null;
    if (this.damaged) this.#write(newAccount());
  }

  /** @returns {Account} as all tabs have left it */
  get account() {
    const text = this.storage.getItem(KEY);
    if (text !== this.#text) {
      const found = text === null ? newAccount() : readAccount(text) ?? this.#account;
      this.#text = text;
      this.#account = found;
      const whole = this.#latest.reduce(applied, found);
      if (whole !== found) this.#write(whole);
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
    this.#latest = [...this.#latest, ...events.filter(isRepeatable)].slice(-REPEATED);
    this.#write(after);
    return true;
  }

  /** @param {Account} account */
  #write(account) {
    this.#account = account;
    this.#text = JSON.stringify(account);
    this.storage.setItem(KEY, this.#text);
  }

  /** @returns {OpenDrop[]} drops whose result is not known yet */
  get open() {
    return openDrops(this.account);
  }

  /** @returns {string[]} ended sessions of which some drops are not known */
  get incomplete() {
    return incompleteSessions(this.account);
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

/** @param {AccountEvent} event @returns {boolean} whether it changes nothing the second time */
function isRepeatable({ type }) {
  return type !== "practised" && type !== "reset";
}
