// What the bins pay, solved by the server for the board being edited.

import { ApiError, postJson } from "../net/api.js";
import { byId } from "../util/dom.js";
import { counted } from "../util/format.js";

/** @import { Board } from "../model/board.js" */
/** @import { PayoutsReply } from "../net/replies.js" */

/** The button and the choice of risk beside it. */
export class PayoutSolver {
  /**
   * @param {() => Board} board
   * @param {(board: Board) => void} change puts another board in its place
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
      this.say(`Payouts solved by ${counted(reply.chosen_by, "drop")}; by ${counted(reply.drops, "other")} ` +
        `they give back ${percent(returned)} ± ${percent(doubt)}, ` +
        `from the worst aim ${percent(reply.least.return)}.`);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.say(`No payouts: ${error.message}`);
    } finally {
      this.button.disabled = false;
    }
  }
}

/** @param {number} value */
const percent = (value) => `${(100 * value).toFixed(1)} %`;
