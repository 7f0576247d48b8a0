// The account as this browser keeps it, for all its tabs: read anew before each change.

import { applied, balanceOf, knownDrops, newAccount, openDrops, refillOf } from "../../model/player/account.js";
import { Mark } from "./mark.js";

/** @import { Account, AccountEvent, OpenDrop } from "../../model/player/account.js" */
/** @import { FairPlayListener } from "../fairness/fair-play.js" */

const KEY = "plinko.account.1";

/** One player's credits. */
export class Wallet {
  #text = "";
  #account = newAccount();

  /** @param {Pick<Storage, "getItem" | "setItem">} storage */
  constructor(storage) {
    this.storage = storage;
    this.mark = new Mark(storage);
  }

  /** @returns {Account} as the last of all tabs left it */
  get account() {
    const text = this.storage.getItem(KEY) ?? "";
    if (text !== this.#text) {
      this.#text = text;
      this.#account = text ? JSON.parse(text) : newAccount();
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

  /** @returns {number} credits that are on no drop, minor units */
  get balance() {
    return balanceOf(this.account);
  }

  /** @returns {OpenDrop[]} drops whose end has not been heard of */
  get open() {
    return openDrops(this.account);
  }

  /** @param {string} room @returns {OpenDrop[]} those that fell there */
  openIn(room) {
    return this.open.filter((drop) => drop.room === room);
  }

  /**
   * What a room's sessions tell the account.
   * @param {string} room
   * @param {(session: string) => void} onBehind the server has taken drops that nobody here heard of
   * @returns {Required<Pick<FairPlayListener, "onStaked" | "onOver" | "onRejoined">>}
   */
  hearing(room, onBehind) {
    return {
      onStaked: ({ session, drop, stake, ball, seed }) => {
        this.apply({ type: "staked", session, drop, stake, room, ball, seed });
      },
      onOver: (session, total) => this.apply({ type: "over", session, total }),
      onRejoined: ({ session, drops }) => {
        if (drops > knownDrops(this.account, session)) onBehind(session);
      },
    };
  }

  get canRefill() {
    return refillOf(this.account) !== null;
  }

  refill() {
    const refill = refillOf(this.account);
    if (refill) this.apply(refill);
  }
}
