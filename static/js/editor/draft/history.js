// Undo and redo: the boards before and after the current one. Pure.

/** @import { Board } from "../../model/board.js" */

const KEPT = 200;

/** Keeps references to boards, which suffices because no board is changed in place. */
export class EditHistory {
  /** @type {Board[]} */
  #past = [];
  /** @type {Board[]} */
  #future = [];

  /** @param {Board} board */
  constructor(board) {
    this.board = board;
  }

  get canUndo() {
    return this.#past.length > 0;
  }

  get canRedo() {
    return this.#future.length > 0;
  }

  /** @param {Board} board becomes the current one */
  push(board) {
    if (board === this.board) return;
    this.#past = [...this.#past, this.board].slice(-KEPT);
    this.#future = [];
    this.board = board;
  }

  /** @returns {boolean} whether there was something to undo */
  undo() {
    const before = this.#past.pop();
    if (!before) return false;
    this.#future.push(this.board);
    this.board = before;
    return true;
  }

  /** @returns {boolean} whether there was something to redo */
  redo() {
    const after = this.#future.pop();
    if (!after) return false;
    this.#past.push(this.board);
    this.board = after;
    return true;
  }
}
