// Undo and redo: the boards before and after the current one. Pure.

/** @import { Board } from "../../model/board.js" */

const KEPT = 200;

/** Keeps references to boards, which suffices because no board is changed in place. */
export class EditHistory {
  /** @type {Board[]} the oldest first */
  #boards;
  #at = 0;

  /** @param {Board} board */
  constructor(board) {
    this.#boards = [board];
  }

  get board() {
    return this.#boards[this.#at];
  }

  get canUndo() {
    return this.#at > 0;
  }

  get canRedo() {
    return this.#at < this.#boards.length - 1;
  }

  /** @param {Board} board becomes the current one */
  push(board) {
    if (board === this.board) return;
    this.#boards = [...this.#boards.slice(0, this.#at + 1), board].slice(-KEPT);
    this.#at = this.#boards.length - 1;
  }

  /** @param {"undo" | "redo"} way @returns {boolean} whether there was something to undo or to redo */
  travel(way) {
    if (way === "undo" ? !this.canUndo : !this.canRedo) return false;
    this.#at += way === "undo" ? -1 : 1;
    return true;
  }
}
