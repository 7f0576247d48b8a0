// Asks the server whether a board can be played, a moment after it was changed, and says where not.

import { ApiError, postJson } from "../net/api.js";

const PAUSE = 250; // ms without a change before the server is asked

/**
 * @typedef {{ok: true, digest: string, board: any}
 *   | {ok: false, message: string, field: string | null}} Verdict
 */

/** Checks the newest board only; `onVerdict(verdict, board)` comes for no older one. */
export class EditorCheck {
  #timer = 0;
  #asked = null;

  /** @param {(verdict: Verdict, board: any) => void} onVerdict */
  constructor(onVerdict) {
    this.onVerdict = onVerdict;
  }

  /** @param {any} board */
  ask(board) {
    clearTimeout(this.#timer);
    this.#asked = board;
    this.#timer = setTimeout(() => this.#run(board), PAUSE);
  }

  async #run(board) {
    const verdict = await judge(board);
    if (this.#asked === board) this.onVerdict(verdict, board);
  }
}

/** @returns {Promise<Verdict>} */
async function judge(board) {
  try {
    const { digest, board: whole } = await postJson("boards/check", board);
    return { ok: true, digest, board: whole };
  } catch (error) {
    if (!(error instanceof ApiError)) throw error;
    return { ok: false, message: error.message, field: error.field };
  }
}
