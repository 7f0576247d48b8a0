// Undo and redo: the boards before and after the one that is edited. Pure.

/** @import { Board } from "../../model/board.js" */

const KEPT = 200;

/** Boards are never changed in place, so that keeping them is enough. */
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

  /** @param {Board} board takes the place of the present one */
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

  /** @returns {boolean} whether there was something to do again */
  redo() {
    const after = this.#future.pop();
    if (!after) return false;
    this.#past.push(this.board);
    this.board = after;
    return true;
  }
}
