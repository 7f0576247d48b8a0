// Verify: recomputes a landed drop in this page, and compares it with the result that the server sent.

import { getJson, messageOf } from "../../net/api.js";
import { t } from "../../texts/text.js";
import { make, say } from "../../util/dom.js";

/** @import { Board } from "../../model/board.js" */
/** @import { Played } from "../../model/player/account.js" */
/** @import { BoardReply } from "../../net/replies.js" */
/** @import { Game } from "../game.js" */

/** @typedef {{impacts: number, fault: string | null}} Verdict fault: what differs, as a text */

/** Recomputes drops of the history. It keeps the boards of the rooms visited, so that no server is asked. */
export class Prover {
  /** @type {Map<string, Board>} by digest */
  #boards = new Map();

  /** @param {Game} game */
  constructor(game) {
    this.solver = game.solver;
    game.on("table", ({ hello }) => this.#boards.set(hello.board_digest, hello.board));
  }

  /** @param {Played} drop @returns {boolean} whether there is a digest to compare with */
  canVerify({ digest, knocked }) {
    return this.solver !== null && Boolean(digest) && !knocked;
  }

  /**
   * Shows the recomputed drop in its row of the history, impact by impact.
   * @param {Played} drop
   * @param {HTMLElement} row
   */
  async show(drop, row) {
    row.querySelector(".proof")?.remove();
    const dots = make("span", { class: "proof-dots", "aria-hidden": "true" });
    const words = make("span", { class: "proof-words", role: "status" }, t("page.computing"));
    row.append(make("div", { class: "proof" }, dots, words));
    try {
      const { impacts, fault } = await this.#verify(drop);
      await turn(dots, impacts, fault === null ? "good" : "bad");
      const verified = t("fair.verified", { n: impacts });
      say(words, fault === null ? "good" : "bad", fault ?? verified);
    } catch (error) {
      say(words, "bad", t("fair.unverified", { why: messageOf(error) }));
    }
  }

  /** @param {Played} drop @returns {Promise<Verdict>} */
  async #verify({ seed, x, aim, digest: told, bin, score, board, boardDigest }) {
    if (!this.solver || !told) throw new Error(t("fair.no-solver"));
    const known = this.#boards.get(boardDigest ?? "")
      ?? /** @type {BoardReply} */ (await getJson(`boards/${encodeURIComponent(board)}`)).board;
    const drop = this.solver.drop(known, { seed, x, aim });
    const { digest, impacts: { length: impacts } } = drop;
    let fault = null;
    if (boardDigest && drop.boardDigest !== boardDigest) fault = t("fair.other-board");
    else if (!digest.startsWith(told)) {
      fault = t("fair.other-path");
    } else if (drop.bin !== bin || drop.score !== score) {
      fault = t("fair.other-bin", { found: String(drop.bin), told: String(bin) });
    }
    return { impacts, fault };
  }
}

/**
 * Shows one dot per impact, and colours one dot per frame.
 * @param {HTMLElement} dots
 * @param {number} count
 * @param {"good" | "bad"} tone
 */
async function turn(dots, count, tone) {
  const all = Array.from({ length: count }, () => make("i"));
  dots.replaceChildren(...all);
  const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
  for (const dot of all) {
    dot.dataset.tone = tone;
    if (!still) await new Promise(requestAnimationFrame);
  }
}
