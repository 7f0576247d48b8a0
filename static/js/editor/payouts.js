// Has the server solve the payout table of the edited board.

import { ApiError, postJson } from "../net/api.js";
import { t } from "../texts/text.js";
import { byId } from "../util/dom.js";
import { percent } from "../util/format.js";

/** @import { Board } from "../model/board.js" */
/** @import { PayoutsReply } from "../net/replies.js" */

/**
 * Connects the button, with the choice of risk next to it.
 * @param {() => Board} board
 * @param {(board: Board) => void} change replaces the board
 * @param {(text: string) => void} say
 */
export function offerPayouts(board, change, say) {
  const button = byId("solve", HTMLButtonElement);
  button.addEventListener("click", async () => {
    const asked = board();
    button.disabled = true;
    try {
      const risk = byId("solve-risk", HTMLSelectElement).value;
      const reply = /** @type {PayoutsReply} */ (await postJson("payouts", { board: asked, risk }));
      if (asked !== board()) return;
      change({ ...asked, bins: { ...asked.bins, multipliers: reply.multipliers } });
      const [{ return: returned, doubt }] = reply.aims;
      const solved = t("editor.solved", {
        chosen: reply.chosen_by, judged: reply.drops, returned: percent(returned),
        doubt: percent(doubt), least: percent(reply.least.return),
      });
      const { rare_bins: rare, falling_bins: falling } = reply;
      const warnings = [
        rare.length && t("editor.payouts-rare", { bins: rare.join(", ") }),
        falling.length && t("editor.payouts-fall", { bins: falling.join(", ") }),
      ];
      say([solved, ...warnings].filter(Boolean).join(" "));
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      say(t("editor.no-payouts", { why: error.message }));
    } finally {
      button.disabled = false;
    }
  });
}
