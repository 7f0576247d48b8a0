// Asks the server whether the edited board is playable, a moment after each change.

import { ApiError, postJson } from "../net/api.js";

/** @import { Board } from "../model/board.js" */
/** @import { BoardReply } from "../net/replies.js" */

const PAUSE = 250; // ms without a change before the server is asked

/**
 * @typedef {{ok: true, digest: string, board: Board}
 *   | {ok: false, message: string, field: string | null}} Verdict
 */

/** Checks boards; `onVerdict(verdict, board)` is called only for the newest one. */
export class BoardCheck {
  #timer = 0;
  /** @type {Board | null} */
  #asked = null;

  /** @param {(verdict: Verdict, board: Board) => void} onVerdict */
  constructor(onVerdict) {
    this.onVerdict = onVerdict;
  }

  /** @param {Board} board */
  ask(board) {
    clearTimeout(this.#timer);
    this.#asked = board;
    this.#timer = setTimeout(() => this.#run(board), PAUSE);
  }

  /** @param {Board} board */
  async #run(board) {
    const verdict = await judge(board);
    if (this.#asked === board) this.onVerdict(verdict, board);
  }
}

/** @param {Board} board @returns {Promise<Verdict>} */
async function judge(board) {
  try {
    const reply = await postJson("boards/check", board);
    const { digest, board: whole } = /** @type {BoardReply} */ (reply);
    return { ok: true, digest, board: whole };
  } catch (error) {
    if (!(error instanceof ApiError)) throw error;
    return { ok: false, message: error.message, field: error.field };
  }
}
