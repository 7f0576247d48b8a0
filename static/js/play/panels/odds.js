// The room's average return and the odds of its top award: from the server's record, or counted in this page.

import { measuredOdds, oddsAt, oddsWords } from "../../model/odds.js";
import { readBoardName } from "../../model/presets.js";
import { getJson } from "../../net/api.js";
import { PHYSICS_VERSION } from "../../solver/digest.js";
import { Batch } from "../../solver/many/batch.js";
import { t } from "../../texts/text.js";
import { byId } from "../../util/dom.js";
import { local } from "../../util/storage.js";
import { isRecord, readStored } from "../../util/stored.js";
import { choiceOf } from "../rooms.js";

/** @import { Hello } from "../../model/messages.js" */
/** @import { Odds } from "../../model/odds.js" */
/** @import { OddsReply } from "../../net/replies.js" */
/** @import { Game } from "../game.js" */

const DROPS = 20_000; // a worker computes them in about a second
const KEY = `plinko.odds.${PHYSICS_VERSION}`;

/**
 * The odds that this browser has stored, by board name, so that a board is measured only once.
 * @returns {Record<string, {share: number, measured?: Odds}>}
 */
const known = () => readStored(local, KEY, isKnown) ?? {};

/** @param {unknown} value @returns {value is Record<string, {share: number, measured?: Odds}>} */
function isKnown(value) {
  return isRecord(value) && Object.values(value).every((each) => isRecord(each) && typeof each.share === "number"
    && (each.measured === undefined || (isRecord(each.measured) && Array.isArray(each.measured.chances))));
}

/** @param {string} name of a board @returns {number | null} its average return; null if not stored */
export function returnsOf(name) {
  return known()[name]?.share ?? null;
}

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
    const { board_name: name } = hello;
    const entered = originOf(hello);
    if (entered === digest) return; // a reconnect
    digest = entered;
    odds = [];
    game.odds = null;
    // Where balls knock each other, the odds of a single ball do not hold. Boards outside the form have no record.
    const choice = choiceOf(hello);
    const found = choice && !choice.knock && !hello.draw ? await oddsOf(hello).catch(() => []) : [];
    if (entered !== digest) return;
    odds = found;
    if (odds.length) {
      const [first] = odds;
      const learnt = { share: first.return, ...(first.measured && { measured: first }) };
      local.setItem(KEY, JSON.stringify({ ...known(), [name]: learnt }));
    } else tell(null);
    show();
  });
}

/** @param {Hello} hello @returns {Promise<Odds[]>} by aim */
async function oddsOf({ board, board_name: name, board_digest: digest }) {
  if (readBoardName(name)) {
    const found = /** @type {OddsReply} */ (await getJson(`boards/${name}/odds`));
    return found.board_digest === digest ? found.aims : [];
  }
  const kept = known()[name]?.measured;
  if (kept) return [kept];
  const tally = await new Batch({ board, first: "0", drops: DROPS }, () => {}).done;
  return tally ? [measuredOdds(tally, board.bins.multipliers)] : [];
}
