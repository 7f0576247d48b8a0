// What the table gives back on average and how often its top award comes: of record, or counted in this page.

import { measuredOdds, oddsAt, oddsWords } from "../../model/odds.js";
import { readBoardName } from "../../model/presets.js";
import { getJson } from "../../net/api.js";
import { PHYSICS_VERSION } from "../../solver/digest.js";
import { Batch } from "../../solver/many/batch.js";
import { t } from "../../texts/text.js";
import { byId } from "../../util/dom.js";
import { choiceOf } from "../rooms.js";

/** @import { Hello } from "../../model/messages.js" */
/** @import { Odds } from "../../model/odds.js" */
/** @import { OddsReply } from "../../net/replies.js" */
/** @import { Game } from "../game.js" */

const DROPS = 20_000; // counted in a worker, in about a second
const KEY = `plinko.odds.${PHYSICS_VERSION}`;

/**
 * What this browser has learnt, by the names of boards: what was measured is not measured again.
 * @returns {Record<string, {share: number, measured?: Odds}>}
 */
const known = () => JSON.parse(window.localStorage.getItem(KEY) ?? "{}");

/** @param {string} name of a board @returns {number | null} its average return, where this browser knows it */
export function returnsOf(name) {
  return known()[name]?.share ?? null;
}

/** @param {string} name of a board @param {Odds} odds */
function keep(name, odds) {
  const learnt = { share: odds.return, ...(odds.measured && { measured: odds }) };
  window.localStorage.setItem(KEY, JSON.stringify({ ...known(), [name]: learnt }));
}

/** @param {Hello} hello @returns {string} what its odds follow from: a draw has odds of its own */
const oddsOf = ({ draw, board_digest: board }) => draw?.digest ?? board;

/** Of one table at a time. */
export class OddsNote {
  /** @type {Odds[]} by aim */
  #odds = [];
  #digest = "";

  /** @param {Game} game */
  constructor(game) {
    this.game = game;
    game.on("table", ({ hello }) => this.#learn(hello));
    game.on("choice", () => this.#show());
  }

  /** @param {Hello} hello */
  async #learn(hello) {
    const { board_name: name } = hello;
    const digest = oddsOf(hello);
    if (digest === this.#digest) return; // a line that came back
    this.#digest = digest;
    this.#odds = [];
    this.game.odds = null;
    // Where balls knock each other no odds of one ball hold; boards that cannot be chosen were never counted.
    const choice = choiceOf(hello);
    const odds = choice && !choice.knock && !hello.draw ? await this.#find(hello).catch(() => []) : [];
    if (digest !== this.#digest) return;
    this.#odds = odds;
    if (odds.length) keep(name, odds[0]);
    else this.#tell(null);
    this.#show();
  }

  /** @param {Hello} hello @returns {Promise<Odds[]>} */
  async #find({ board, board_name: name, board_digest: digest }) {
    if (readBoardName(name)) {
      const found = /** @type {OddsReply} */ (await getJson(`boards/${name}/odds`));
      return found.board_digest === digest ? found.aims : [];
    }
    const kept = known()[name]?.measured;
    if (kept) return [kept];
    const tally = await new Batch({ board, first: "0", drops: DROPS }, () => {}).done;
    return tally ? [measuredOdds(tally, board.bins.multipliers)] : [];
  }

  #show() {
    const { hello } = this.game.room;
    // Those of the table before may come late, when another is there already.
    const here = hello && oddsOf(hello) === this.#digest;
    const odds = here ? oddsAt(this.#odds, this.game.choice.aim, hello.board.drop.x) : null;
    const words = odds ? oddsWords(odds) : "";
    byId("odds-note").textContent = hello?.draw ? t("draw.note") : words;
    if (odds !== this.game.odds) this.#tell(odds);
  }

  /** @param {Odds | null} odds */
  #tell(odds) {
    this.game.odds = odds;
    this.game.tell("odds", odds);
  }
}
