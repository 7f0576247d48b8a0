// Verify: a landed drop is computed anew in this page, and held against what the table told of it.

import { getJson, messageOf } from "../../net/api.js";
import { t } from "../../texts/text.js";
import { make } from "../../util/dom.js";

/** @import { Board } from "../../model/board.js" */
/** @import { Played } from "../../model/player/account.js" */
/** @import { BoardReply } from "../../net/replies.js" */
/** @import { Solver } from "../../solver/solver.js" */

const SHOWN = 12; // digits of a digest

/** @typedef {{impacts: number, fault: string | null, digest: string}} Verdict fault: what differs */

/** Computes drops of the list again. The boards of the tables played at are kept: no server is asked. */
export class Prover {
  /** @type {Map<string, Board>} by digest */
  #boards = new Map();

  /** @param {Solver | null} solver null where nothing can be computed here */
  constructor(solver) {
    this.solver = solver;
  }

  /** @param {string} digest @param {Board} board of a table */
  know(digest, board) {
    this.#boards.set(digest, board);
  }

  /** @param {Played} drop @returns {boolean} whether there is something to hold it against */
  canVerify({ digest, knocked }) {
    return this.solver !== null && Boolean(digest) && !knocked;
  }

  /**
   * Shows in a row of the list how the drop comes out again, impact by impact.
   * @param {Played} drop
   * @param {HTMLElement} row
   */
  async show(drop, row) {
    row.querySelector(".proof")?.remove();
    const dots = make("span", { class: "proof-dots", "aria-hidden": "true" });
    const words = make("span", { class: "proof-words", role: "status" }, t("page.computing"));
    row.append(make("div", { class: "proof" }, dots, words));
    try {
      const { impacts, fault, digest } = await this.#verify(drop);
      await turn(dots, impacts, fault === null ? "good" : "bad");
      words.dataset.tone = fault === null ? "good" : "bad";
      words.textContent = fault ?? t("fair.verified", { n: impacts, digest: digest.slice(0, SHOWN) });
    } catch (error) {
      words.dataset.tone = "bad";
      words.textContent = t("fair.unverified", { why: messageOf(error) });
    }
  }

  /** @param {Played} drop @returns {Promise<Verdict>} */
  async #verify({ seed, x, aim, digest: told, bin, score, board, boardDigest }) {
    if (!this.solver || !told) throw new Error(t("fair.no-solver"));
    const known = this.#boards.get(boardDigest ?? "") ?? (await fetched(board));
    const drop = this.solver.drop(known, { seed, x, aim });
    const impacts = drop.impacts.length;
    const { digest } = drop;
    if (boardDigest && drop.boardDigest !== boardDigest) {
      return { impacts, digest, fault: t("fair.other-board") };
    }
    if (!digest.startsWith(told)) {
      const fault = t("fair.other-path", { here: digest.slice(0, SHOWN), told: told.slice(0, SHOWN) });
      return { impacts, digest, fault };
    }
    const paid = drop.bin === bin && drop.score === score;
    return { impacts, digest, fault: paid ? null : t("fair.other-bin", { found: String(drop.bin), told: String(bin) }) };
  }
}

/** @param {string} address what REST calls the board @returns {Promise<Board>} */
async function fetched(address) {
  const reply = await getJson(`boards/${encodeURIComponent(address)}`);
  return /** @type {BoardReply} */ (reply).board;
}

/**
 * One dot an impact; they take their colour one after the other, a frame of the screen each.
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
