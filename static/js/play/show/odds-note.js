// What the chosen aim gives back on this table, in a line, where it was counted.

import { oddsAt, oddsWords } from "../../model/odds.js";
import { readBoardName } from "../../model/presets.js";
import { getJson, messageOf } from "../../net/api.js";
import { t } from "../../texts/text.js";
import { byId } from "../../util/dom.js";

/** @import { Hello } from "../../model/messages.js" */
/** @import { Odds } from "../../model/odds.js" */
/** @import { OddsReply } from "../../net/replies.js" */

/** Of one table at a time. */
export class OddsNote {
  /** @type {Odds[]} by aim, where they are known of the board */
  #odds = [];
  #digest = "";
  #middle = 0;

  /** @param {{onOdds: (odds: Odds | null) => void, aim: () => number | null, say: (text: string) => void}} table */
  constructor(table) {
    this.table = table;
  }

  /** @param {Hello} hello */
  async learn({ board, board_digest: digest, board_name: name, mode }) {
    this.#odds = [];
    this.#digest = digest;
    this.#middle = board.drop.x;
    try {
      // Where balls knock each other no odds of one ball hold; other boards were never counted.
      if (mode !== "interacting" && readBoardName(name)) {
        const found = /** @type {OddsReply} */ (await getJson(`boards/${name}/odds`));
        if (digest === this.#digest && digest === found.board_digest) this.#odds = found.aims;
      }
    } catch (error) {
      this.table.say(t("play.odds-unknown", { why: messageOf(error) }));
    }
    if (digest === this.#digest) this.#show();
  }

  /** The aim is another. */
  aimed() {
    if (this.#odds.length) this.#show();
  }

  #show() {
    const odds = oddsAt(this.#odds, this.table.aim(), this.#middle);
    byId("odds-note").textContent = odds ? oddsWords(odds) : "";
    this.table.onOdds(odds);
  }
}
