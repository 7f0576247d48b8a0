// Undo and redo: the boards before and after the one that is edited. Pure.

const KEPT = 200;

/** Boards are never changed in place, so that keeping them is enough. */
export class EditHistory {
  #past = [];
  #future = [];

  /** @param {any} board */
  constructor(board) {
    this.board = board;
  }

  get canUndo() {
    return this.#past.length > 0;
  }

  get canRedo() {
    return this.#future.length > 0;
  }

  /** @param {any} board takes the place of the present one */
  push(board) {
    if (board === this.board) return;
    this.#past = [...this.#past, this.board].slice(-KEPT);
    this.#future = [];
    this.board = board;
  }

  /** @returns {boolean} whether there was something to undo */
  undo() {
    if (!this.canUndo) return false;
    this.#future.push(this.board);
    this.board = this.#past.pop();
    return true;
  }

  /** @returns {boolean} whether there was something to do again */
  redo() {
    if (!this.canRedo) return false;
    this.#past.push(this.board);
    this.board = this.#future.pop();
    return true;
  }
}
