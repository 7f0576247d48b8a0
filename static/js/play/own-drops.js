// This visitor's drops at a table: asked for, in flight, landed, and found again after a disconnect.

import { payoutOf } from "../fairness/payout.js";
import { MINOR_UNITS } from "../model/player/account.js";
import { boardAddress, getJson } from "../net/api.js";
import { dropPath } from "../net/drop-address.js";
import { t } from "../texts/text.js";

/** @import { Accepted, BriefAccepted, Hello, Landed, Missed } from "../model/messages.js" */
/** @import { DropRecord } from "../model/motion/drop.js" */
/** @import { FairPlace, OpenDrop, Played } from "../model/player/account.js" */
/** @import { Ball, Table } from "../model/table/table.js" */
/** @import { Store } from "./store.js" */

/**
 * @typedef {{id: number, seed: string, x: number, explicit: boolean, aim?: number, by?: string}} Accepting
 *   what a drop needs to know of its ball
 * @typedef {{ref: string, stake: number, practice: boolean, ball: Accepting | null, fair?: FairPlace,
 *   shown?: Played}} OwnDrop ball: null until accepted; fair: of a staked one, from then on
 *
 * @typedef {{bin: number | null, score: number, digest: string | null}} End
 */

/** Drops of ours that the table has not settled yet, by the ref under which they were asked for. */
export class OwnDrops {
  /** @type {Map<string, OwnDrop>} */
  #open = new Map();
  /** @type {OwnDrop[]} those under way when the line broke, until the server tells their fate */
  #pending = [];
  /** @type {Pick<Hello, "mode" | "board_name" | "board_digest" | "balls">} */
  #hello = { mode: "independent", board_name: "", board_digest: "", balls: [] };
  /** @type {Table | null} */
  #table = null;
  /** What REST calls the board. */
  address = "";

  /** @param {Pick<Store, "tell" | "say">} news */
  constructor(news) {
    this.news = news;
  }

  /** How many have not settled yet. */
  get count() {
    return this.#open.size;
  }

  /** How many are still to be seen to land. */
  get unseen() {
    return this.#which(({ shown }) => !shown).length;
  }

  /** How many the table has not answered yet. */
  get unanswered() {
    return this.#which(({ ball }) => !ball).length;
  }

  /** @returns {number} stakes of drops that the table has not answered yet */
  get held() {
    return this.#which(({ ball }) => !ball).reduce((sum, { stake }) => sum + stake, 0);
  }

  /** @param {(drop: OwnDrop) => boolean} holds */
  #which(holds) {
    return [...this.#open.values()].filter(holds);
  }

  /** @param {string} ref @param {number} stake asked for just now @param {boolean} practice */
  add(ref, stake, practice) {
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
    return this.#open.has(ref ?? "");
  }

  /**
   * @param {string | null | undefined} ref
   * @param {Ball} ball it is in flight
   * @param {FairPlace} [fair] where it stands in its session
   */
  accepted(ref, ball, fair) {
    const drop = this.#open.get(ref ?? "");
    if (!drop) return;
    ball.stake = drop.practice ? undefined : drop.stake;
    Object.assign(drop, { ball, fair });
  }

  /** @param {string | null | undefined} ref @returns {boolean} whether the table has not answered it */
  awaits(ref) {
    return this.#open.get(ref ?? "")?.ball === null;
  }

  /**
   * Drops that an earlier life of the page asked for, or another tab, go on.
   * @param {OpenDrop[]} found
   * @returns {Set<string>} sessions of those that do not fall here any more
   */
  adopt(found) {
    return new Set(found.filter((drop) => !this.#adopt(drop)).map(({ session }) => session));
  }

  /** @param {OpenDrop} found @returns {boolean} false when its ball is not in flight here */
  #adopt({ session, drop: number, stake, ball: id, seed }) {
    if (this.#which(({ fair }) => fair?.session === session && fair.drop === number).length) return true;
    const ball = id === undefined ? undefined : this.#table?.balls.get(id);
    if (!ball || ball.landed || ball.seed !== seed) return false;
    const ref = `${session}-${number}`;
    const fair = { session, drop: number };
    Object.assign(ball, { mine: true, stake: stake / MINOR_UNITS });
    this.#open.set(ref, { ref, ball, stake: stake / MINOR_UNITS, practice: false, fair });
    return true;
  }

  /** @param {string | null | undefined} ref the table did not take it */
  refused(ref) {
    if (this.#open.delete(ref ?? "")) this.news.tell("refused", { ref: ref ?? "" });
  }

  /** @param {Ball} ball anybody's @param {Landed} outcome it is seen to land so */
  seen(ball, outcome) {
    // After a lost line a ball that was shown at once is seen to fall once more.
    for (const drop of this.#which((each) => each.ball === ball && !each.shown)) this.#see(drop, ball, outcome);
  }

  /** @param {Ball} ball anybody's @param {Landed} landed */
  settled(ball, landed) {
    for (const drop of this.#which((each) => each.ball === ball)) this.#close(drop, ball, landed);
  }

  /**
   * After a disconnect: our balls still fly, have landed meanwhile, or landed where their seed says.
   * @param {NonNullable<Missed["events"]>} missed
   */
  reclaim(missed) {
    const accepted = missed.filter((event) => event.type === "accepted");
    const landed = missed.filter((event) => event.type === "landed");
    for (const drop of this.#pending) {
      const heard = accepted.find(({ ref }) => ref === drop.ref);
      drop.ball ??= acceptingOf(heard);
      drop.fair ??= fairPlaceOf(heard);
      if (drop.ball) this.#find(drop, drop.ball, landed);
      else {
        this.refused(drop.ref);
        this.news.say(t("play.line-broke-drop"));
      }
    }
  }

  /** @param {OwnDrop} drop @param {Accepting} ball @param {Landed[]} landed meanwhile */
  #find(drop, ball, landed) {
    const { seed, x, explicit, aim } = ball;
    const there = this.#hello.balls.find((start) => start.seed === seed && start.x === x);
    const flying = there && this.#table?.balls.get(there.ball);
    const end = landed.find((event) => event.ball === ball.id);
    if (flying) {
      drop.ball = Object.assign(flying, { mine: true, explicit, aim, stake: drop.practice ? undefined : drop.stake });
    } else if (end) this.#close(drop, ball, end);
    else this.#recover(drop, ball);
  }

  /** @param {OwnDrop} drop @param {Accepting} ball that landed while nobody told us */
  async #recover(drop, ball) {
    try {
      if (this.#hello.mode === "interacting") throw new Error(t("play.knocked"));
      const { seed, x, explicit, aim } = ball;
      const address = { board: this.address, seed, x: explicit ? x : null, aim };
      this.#close(drop, ball, /** @type {DropRecord} */ (await getJson(dropPath(address))));
    } catch {
      this.refused(drop.ref);
      this.news.say(t("play.unknown"));
    }
  }

  /** @param {OwnDrop} drop @param {Accepting} ball @param {End} end as the table has it */
  #close(drop, ball, end) {
    this.#open.delete(drop.ref);
    if (!drop.shown) this.#see(drop, ball, end);
    else if (drop.shown.score !== end.score && drop.fair) {
      const payout = payoutOf(Math.round(drop.stake * MINOR_UNITS), end.score);
      this.news.tell("corrected", { ...drop.fair, payout });
    }
    this.news.tell("room", null);
  }

  /** @param {OwnDrop} drop @param {Accepting} ball @param {End} end */
  #see(drop, ball, end) {
    drop.shown = this.#played(drop, ball, end);
    this.news.tell("seen", drop.shown);
  }

  /** @param {OwnDrop} drop @param {Accepting} ball @param {End} end @returns {Played} */
  #played({ ref, stake, practice, fair }, { seed, x, explicit, aim, by }, { bin, score, digest }) {
    const { mode, board_name: name, board_digest: boardDigest } = this.#hello;
    const paid = payoutOf(Math.round(stake * MINOR_UNITS), score) / MINOR_UNITS;
    return {
      board: this.address, boardDigest, name, seed, x: explicit ? x : null, aim: aim ?? null, ref,
      knocked: mode === "interacting", stake, paid, practice, bin, score, digest, ...(fair && { fair }),
      ...(by && { by }),
    };
  }

  /** @param {Hello} hello */
  async #learnAddress(hello) {
    // Until the list of boards is there, and without it, links name the board by its digest.
    this.address = hello.board_digest;
    this.address = await boardAddress(hello).catch(() => hello.board_digest);
  }
}

/**
 * @param {Accepted | BriefAccepted} [event]
 * @returns {FairPlace | undefined} where a staked drop stands in its session
 */
export function fairPlaceOf(event) {
  if (!event?.receipt) return undefined;
  const { session, drop } = event.receipt.receipt;
  return { session, drop };
}

/** @param {Accepted} [event] @returns {Accepting | null} from an acceptance that came late */
function acceptingOf(event) {
  if (!event) return null;
  const { ball: id, seed, x, explicit_x: explicit, aim } = event;
  return { id, seed, x, explicit, aim };
}
