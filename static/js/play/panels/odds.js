// The room's average return and the odds of its top award, from the server's record.

import { oddsAt, oddsWords } from "../../model/odds.js";
import { readBoardName } from "../../model/presets.js";
import { getJson } from "../../net/api.js";
import { t } from "../../texts/text.js";
import { byId } from "../../util/dom.js";

/** @import { Hello } from "../../model/messages.js" */
/** @import { Odds } from "../../model/odds.js" */
/** @import { OddsReply } from "../../net/replies.js" */
/** @import { Game } from "../game.js" */

/** @param {Hello} hello @returns {string} the digest of the draw, if there is one, else of the board */
const originOf = ({ draw, board_digest: board }) => draw?.digest ?? board;

/** @param {Game} game */
export function showOdds(game) {
  /** @type {Odds[]} by aim */
  let odds = [];
  let digest = "";

  /** @param {Odds | null} now */
  const tell = (now) => {
    game.odds = now;
    game.tell("odds", now);
  };
  const show = () => {
    const { hello } = game.room;
    // The odds may belong to the previous room, if the new one's have not arrived.
    const here = hello && originOf(hello) === digest;
    const now = here ? oddsAt(odds, game.choice.aim, hello.board.drop.x) : null;
    const words = now ? oddsWords(now) : "";
    byId("odds-note").textContent = hello?.draw ? t("draw.note") : words;
    if (now !== game.odds) tell(now);
  };
  game.on("choice", show);
  game.on("table", async ({ hello }) => {
    const entered = originOf(hello);
    if (entered === digest) return; // a reconnect
    digest = entered;
    odds = [];
    game.odds = null;
    // Where balls knock each other, the odds of a single ball do not hold. Only presets have a record.
    const counted = readBoardName(hello.board_name) && hello.mode === "independent" && !hello.draw;
    const found = counted ? await oddsOf(hello).catch(() => []) : [];
    if (entered !== digest) return;
    odds = found;
    if (!odds.length) tell(null);
    show();
  });
}

/** @param {Hello} hello @returns {Promise<Odds[]>} by aim */
async function oddsOf({ board_name: name, board_digest: digest }) {
  const found = /** @type {OddsReply} */ (await getJson(`boards/${name}/odds`));
  return found.board_digest === digest ? found.aims : [];
}
