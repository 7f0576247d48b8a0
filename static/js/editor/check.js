// Asks the server whether the edited board is playable.

import { ApiError, postJson } from "../net/api.js";

/** @import { Board } from "../model/board.js" */
/** @import { BoardReply } from "../net/replies.js" */

/**
 * @typedef {{ok: true, digest: string, board: Board}
 *   | {ok: false, message: string, field: string | null}} Verdict
 */

/** @param {Board} board @returns {Promise<Verdict>} */
export async function judge(board) {
  try {
    const reply = await postJson("boards/check", board);
    const { digest, board: whole } = /** @type {BoardReply} */ (reply);
    return { ok: true, digest, board: whole };
  } catch (error) {
    if (!(error instanceof ApiError)) throw error;
    return { ok: false, message: error.message, field: error.field };
  }
}
