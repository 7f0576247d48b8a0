// Practice: a ball that falls in this page alone, while there is no line to the table.

/** @import { Hello } from "../model/messages.js" */
/** @import { Played } from "../model/player/session.js" */
/** @import { Ball, Table } from "../model/table/table.js" */

/** @param {Ball} ball @returns {boolean} whether it is none of the table's */
export function isPractice({ id }) {
  return id < 0;
}

/** Balls of no table: nothing is staked on them, nobody else sees them, no score counts them. */
export class Practice {
  #count = 0;

  /**
   * @param {Table} table one whose paths this page computes
   * @param {{seed: string | null, aim: number | null}} ask
   * @param {number} tick at which it starts
   */
  drop(table, { seed, aim }, tick) {
    this.#count += 1;
    const drawn = seed ?? String(crypto.getRandomValues(new BigUint64Array(1))[0]);
    const start = { ball: -this.#count, seed: drawn, tick, ...(aim !== null && { aim }) };
    const ball = table.accept({ type: "accepted", ...start }, true);
    table.applyLanded({ type: "landed", ball: ball.id, digest: ball.solved?.solved.digest ?? "" });
  }

  /**
   * @param {Hello} hello of its table
   * @param {string} board what REST calls its board
   * @param {Ball} ball that has settled
   * @returns {Played}
   */
  played({ board_digest: boardDigest, board_name: name }, board, { seed, aim, landed }) {
    const { bin = null, score = 1, digest = null } = landed ?? {};
    return {
      board, boardDigest, name, seed, x: null, aim: aim ?? null, stake: 0, bin, score, digest,
      practice: true,
    };
  }
}
