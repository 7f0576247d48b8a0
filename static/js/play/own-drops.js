// This visitor's drops at a table: asked for, in flight, settled, and found again after a disconnect.

import { boardAddress, getJson, messageOf } from "../net/api.js";
import { dropPath } from "../net/drop-address.js";

/** @import { Accepted, Hello, Landed, Missed } from "../model/messages.js" */
/** @import { DropRecord } from "../model/motion/drop.js" */
/** @import { Played } from "../model/session.js" */
/** @import { Ball, Table } from "../model/table/table.js" */

/**
 * @typedef {{id: number, seed: string, x: number, explicit: boolean, aim?: number}} Accepting
 *   what a drop needs to know of its ball
 * @typedef {{ref: string, stake: number, practice: boolean, ball: Accepting | null}} OwnDrop ball:
 *   null until accepted
 *
 * @typedef {object} OwnDropsListener
 * @property {(played: Played) => void} onPlayed a drop of ours has settled
 * @property {(message: string) => void} onError
 */

/** Drops of ours that have not settled yet, by the ref under which they were asked for. */
export class OwnDrops {
  /** @type {Map<string, OwnDrop>} */
  #open = new Map();
  #count = 0;
  /** @type {OwnDrop[]} those under way when the line broke, until the server tells their fate */
  #pending = [];
  /** @type {Pick<Hello, "mode" | "board_name" | "board_digest" | "balls">} */
  #hello = { mode: "independent", board_name: "", board_digest: "", balls: [] };
  /** @type {Table | null} */
  #table = null;
  /** What REST calls the board. */
  address = "";

  /** @param {OwnDropsListener} listener */
  constructor(listener) {
    this.listener = listener;
  }

  /** How many have not settled yet. */
  get count() {
    return this.#open.size;
  }

  /** How many the table has not answered yet. */
  get unanswered() {
    let count = 0;
    for (const { ball } of this.#open.values()) if (ball === null) count += 1;
    return count;
  }

  /** @returns {string} a ref that no drop has had */
  nextRef() {
    this.#count += 1;
    return `d${this.#count - 1}`;
  }

  /** @param {string} ref @param {number} stake asked for just now @param {boolean} [practice] */
  add(ref, stake, practice = false) {
    this.#open.set(ref, { ref, ball: null, stake, practice });
  }

  /**
   * The table is there, or there again.
   * @param {Hello} hello
   * @param {Table} table
   * @returns {boolean} whether drops of ours are pending: what became of them has to be asked
   */
  enter(hello, table) {
    this.#hello = hello;
    this.#table = table;
    this.#learnAddress(hello);
    // What is dropped from here on is not lost, whatever the answer says.
    this.#pending = [...this.#open.values()];
    return this.#pending.length > 0;
  }

  /** @param {string | null | undefined} ref @returns {boolean} whether it is a drop of ours */
  has(ref) {
    return typeof ref === "string" && this.#open.has(ref);
  }

  /** @param {string | null | undefined} ref @param {Ball} ball it is in flight */
  accepted(ref, ball) {
    const drop = this.#open.get(ref ?? "");
    if (drop) drop.ball = ball;
  }

  /** @param {string | null | undefined} ref the table would not take it */
  refused(ref) {
    this.#open.delete(ref ?? "");
  }

  /** @param {Ball} ball whosever @param {Landed} landed */
  settled(ball, landed) {
    for (const drop of this.#open.values()) {
      if (drop.ball === ball) this.#close(drop, ball, landed);
    }
  }

  /**
   * After a disconnect: our balls still fly, have landed meanwhile, or landed where their seed says.
   * @param {NonNullable<Missed["events"]>} missed
   */
  reclaim(missed) {
    const accepted = missed.filter((event) => event.type === "accepted");
    const landed = missed.filter((event) => event.type === "landed");
    for (const drop of this.#pending) {
      drop.ball ??= acceptingOf(accepted.find(({ ref }) => ref === drop.ref));
      if (drop.ball) this.#find(drop, drop.ball, landed);
      else {
        this.#open.delete(drop.ref);
        this.listener.onError("The line broke before the table took a drop. Its stake is back.");
      }
    }
  }

  /** @param {OwnDrop} drop @param {Accepting} ball @param {Landed[]} landed meanwhile */
  #find(drop, ball, landed) {
    const { seed, x, explicit, aim } = ball;
    const there = this.#hello.balls.find((start) => start.seed === seed && start.x === x);
    const flying = there && this.#table?.balls.get(there.ball);
    const end = landed.find((event) => event.ball === ball.id);
    if (flying) drop.ball = Object.assign(flying, { mine: true, explicit, aim });
    else if (end) this.#close(drop, ball, end);
    else this.#recover(drop, ball);
  }

  /** @param {OwnDrop} drop @param {Accepting} ball that landed while nobody told us */
  async #recover(drop, ball) {
    this.#open.delete(drop.ref);
    if (this.#hello.mode === "interacting") {
      this.listener.onError(`What became of seed ${ball.seed} is unknown: others knocked it.`);
      return;
    }
    try {
      const { seed, x, explicit, aim } = ball;
      const address = { board: this.address, seed, x: explicit ? x : null, aim };
      const record = /** @type {DropRecord} */ (await getJson(dropPath(address)));
      this.#close(drop, ball, record);
    } catch (error) {
      this.listener.onError(`What became of seed ${ball.seed} is unknown: ${messageOf(error)}`);
    }
  }

  /**
   * @param {OwnDrop} drop
   * @param {Accepting} ball
   * @param {{bin: number | null, score: number, digest: string | null}} end
   */
  #close({ ref, stake, practice }, { seed, x, explicit, aim }, { bin, score, digest }) {
    this.#open.delete(ref);
    const { mode, board_name: name, board_digest: boardDigest } = this.#hello;
    this.listener.onPlayed({
      board: this.address, boardDigest, name, seed, x: explicit ? x : null, aim: aim ?? null,
      knocked: mode === "interacting", stake, practice, bin, score, digest,
    });
  }

  /** @param {Hello} hello */
  async #learnAddress(hello) {
    this.address = hello.board_digest;
    try {
      this.address = await boardAddress(hello);
    } catch (error) {
      this.listener.onError(`Replay links may not work: ${messageOf(error)}`);
    }
  }
}

/** @param {Accepted} [event] @returns {Accepting | null} from an acceptance that came late */
function acceptingOf(event) {
  if (!event) return null;
  const { ball: id, seed, x, explicit_x: explicit, aim } = event;
  return { id, seed, x, explicit, aim };
}
