// The leaderboard of named players since the page was opened. Pure; its size is bounded, as it may run for days.

import { labelOf } from "../model/board.js";

/** @import { Board } from "../model/board.js" */
/** @import { Landing } from "../model/table/visitors.js" */
/** @import { Rank } from "./options.js" */

export const MOST_NAMES = 300; // beyond it, the name with the oldest last landing is dropped

/**
 * @typedef {object} Leader
 * @property {Landing} best the landing that paid most
 * @property {Landing | null} prize the last one with a prize
 * @property {number} balls
 * @property {number} prizes landings in bins with a label
 */

/** Counts by name, not by visitor: a player who returns under the same name continues. */
export class Leaders {
  /** @type {Map<string, Leader>} in the order of their last landings */
  #known = new Map();

  /** @param {Landing} landing @param {Pick<Board, "bins">} board of the landing */
  note(landing, board) {
    const name = landing.owner?.name;
    if (!name || landing.bin === null) return;
    const old = this.#known.get(name);
    const won = labelOf(board, landing.bin) !== null;
    this.#known.delete(name);
    this.#known.set(name, {
      best: old && old.best.score >= landing.score ? old.best : landing,
      prize: won ? landing : old?.prize ?? null,
      balls: (old?.balls ?? 0) + 1,
      prizes: (old?.prizes ?? 0) + Number(won),
    });
    const [first] = this.#known.keys();
    if (this.#known.size > MOST_NAMES) this.#known.delete(first);
  }

  /** Starts again: another board has other prizes. */
  clear() {
    this.#known.clear();
  }

  /** Ties: the oldest landing first. @param {Rank} rank @param {number} most @returns {Leader[]} the best first */
  top(rank, most) {
    const worth = (/** @type {Leader} */ leader) => (rank === "best" ? leader.best.score : leader[rank]);
    return [...this.#known.values()].filter((leader) => worth(leader) > 0)
      .sort((one, two) => worth(two) - worth(one)).slice(0, most);
  }
}
