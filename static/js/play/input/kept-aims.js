// Where a player aimed on each board, found again in another tab, another day.

/** @import { Board } from "../../model/board.js" */

const KEY = "plinko.aims.1";
const KEPT = 20; // boards

/** Aims by the boards' names. */
export class KeptAims {
  /** @param {Pick<Storage, "getItem" | "setItem">} storage */
  constructor(storage) {
    this.storage = storage;
  }

  /** @returns {[string, number][]} the last changed at the end */
  get #all() {
    return JSON.parse(this.storage.getItem(KEY) ?? "[]");
  }

  /** @param {Board} board @returns {number | null} metres; null where nobody aimed */
  of({ name }) {
    return this.#all.find(([board]) => board === name)?.[1] ?? null;
  }

  /** @param {Board} board @param {number | null} aim metres; null forgets */
  keep({ name }, aim) {
    const others = this.#all.filter(([board]) => board !== name);
    const all = aim === null ? others : [...others, [name, aim]];
    this.storage.setItem(KEY, JSON.stringify(all.slice(-KEPT)));
  }
}
