// Has the server solve the payout table of the edited board.

import { ApiError, postJson } from "../net/api.js";
import { t } from "../texts/text.js";
import { byId } from "../util/dom.js";
import { percent } from "../util/format.js";

/** @import { Board } from "../model/board.js" */
/** @import { PayoutsReply } from "../net/replies.js" */

/** The button, and the choice of risk next to it. */
export class PayoutSolver {
  /**
   * @param {() => Board} board
   * @param {(board: Board) => void} change replaces the board
   * @param {(text: string) => void} say
   */
  constructor(board, change, say) {
    this.board = board;
    this.change = change;
    this.say = say;
    this.button = byId("solve", HTMLButtonElement);
    this.button.addEventListener("click", () => this.#run());
  }

  async #run() {
    const board = this.board();
    this.button.disabled = true;
    try {
      const risk = byId("solve-risk", HTMLSelectElement).value;
      const reply = /** @type {PayoutsReply} */ (await postJson("payouts", { board, risk }));
      if (board !== this.board()) return;
      this.change({ ...board, bins: { ...board.bins, multipliers: reply.multipliers } });
      const [{ return: returned, doubt }] = reply.aims;
      const solved = t("editor.solved", {
        chosen: reply.chosen_by, judged: reply.drops, returned: percent(returned),
        doubt: percent(doubt), least: percent(reply.least.return),
      });
      const warnings = reply.warnings.map((why) => t("editor.payouts-warning", { why }));
      this.say([solved, ...warnings].join(" "));
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.say(t("editor.no-payouts", { why: error.message }));
    } finally {
      this.button.disabled = false;
    }
  }
}
