// This visitor's drops in a room: sent, in flight, landed, and found again after a disconnect.
//
// A drop is added when it is sent, and accepted when the server answers. Then two things happen in either order: the
// picture shows its landing, which makes the result final for the player, and the server sends the landing, which
// removes the drop here. If the server's result differs from the one shown, the payout is corrected.

import { payoutOf } from "../model/payout.js";
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
 *   the fields of a ball that its drop needs
 * @typedef {Pick<Hello, "mode" | "board_name" | "board_digest" | "balls">} Place
 * @typedef {{ref: string, stake: number, practice: boolean, ball: Accepting | null, place: Place, fair?: FairPlace,
 *   shown?: Played}} OwnDrop ball: null until accepted; place: the room as it was then; fair: set for a staked drop;
 *   shown: set once its landing was shown
 *
 * @typedef {{bin: number | null, score: number, digest: string | null}} End
 */

/** Our drops that the server has not settled yet, by ref. */
export class OwnDrops {
  /** @type {Map<string, OwnDrop>} */
  #open = new Map();
  /** @type {OwnDrop[]} those open when the connection broke, until the server reports their results */
  #pending = [];
  /** @type {Place} */
  #hello = { mode: "independent", board_name: "", board_digest: "", balls: [] };
  /** @type {Table | null} */
  #table = null;
  /** The names of boards in REST paths, by digest. @type {Map<string, string>} */
  #addresses = new Map();

  /** @param {Pick<Store, "tell" | "say">} news */
  constructor(news) {
    this.news = news;
  }

  /** The board's name in REST paths. */
  get address() {
    return this.#addressOf(this.#hello);
  }

  /** @param {Place} place @returns {string} its digest, until the list of boards has arrived, or if that fails */
  #addressOf({ board_digest: digest }) {
    return this.#addresses.get(digest) ?? digest;
  }

  /** Drops not settled yet. */
  get count() {
    return this.#open.size;
  }

  /** Drops whose landing has not been shown yet. */
  get unseen() {
    return this.#which(({ shown }) => !shown).length;
  }

  /** Staked drops whose landing has not been shown yet. */
  get atStake() {
    return this.#which(({ shown, practice }) => !shown && !practice).length;
  }

  /** Drops that the server has not answered yet. */
  get unanswered() {
    return this.#which(({ ball }) => !ball).length;
  }

  /** @returns {number} the sum of the stakes of unanswered drops, credits */
  get held() {
    return this.#which(({ ball }) => !ball).reduce((sum, { stake }) => sum + stake, 0);
  }

  /** @param {(drop: OwnDrop) => boolean} holds */
  #which(holds) {
    return [...this.#open.values()].filter(holds);
  }

  /** Adds a drop that was just sent. @param {string} ref @param {number} stake @param {boolean} practice */
  add(ref, stake, practice) {
    this.#open.set(ref, { ref, ball: null, stake, practice, place: this.#hello });
  }

  /**
   * A connection is open, or open again, or its room was reset.
   * @param {Hello} hello
   * @param {Table} table
   * @param {boolean} held whether the connection is still the same: then the server answers what was sent before
   * @returns {boolean} whether drops are pending, so that the server must be asked for their results
   */
  enter(hello, table, held = false) {
    this.#hello = hello;
    this.#table = table;
    void this.#learnAddress(hello);
    // Only drops from before this moment: the server's answer says nothing about later ones.
    const lost = held ? this.#pending : null;
    this.#pending = this.#which((drop) => drop.ball !== null || !lost || lost.includes(drop));
    return this.#pending.length > 0;
  }

  /** @param {string | null | undefined} ref @returns {boolean} whether it is one of our drops */
  has(ref) {
    return this.#open.has(ref ?? "");
  }

  /**
   * @param {string | null | undefined} ref
   * @param {Ball} ball the drop's ball, now in flight
   * @param {FairPlace} [fair] its place in its session
   */
  accepted(ref, ball, fair) {
    const drop = this.#open.get(ref ?? "");
    if (!drop) return;
    ball.stake = drop.practice ? undefined : drop.stake;
    Object.assign(drop, { ball, fair, place: this.#hello });
  }

  /** @param {string | null | undefined} ref @returns {boolean} whether the drop is still unanswered */
  awaits(ref) {
    return this.#open.get(ref ?? "")?.ball === null;
  }

  /**
   * Takes over drops sent before a reload, or by another tab.
   * @param {OpenDrop[]} found
   * @returns {Set<string>} sessions of the drops that are not in flight here any more
   */
  adopt(found) {
    const known = new Set(this.#open.keys());
    const gone = new Set(found.filter((drop) => !this.#adopt(drop)).map(({ session }) => session));
    const adopted = [...this.#open.values()].filter(({ ref }) => !known.has(ref));
    if (adopted.length > 0) this.news.tell("adopted", adopted.map(({ ref, stake }) => ({ ref, stake })));
    return gone;
  }

  /** @param {OpenDrop} found @returns {boolean} false if its ball is not in flight here */
  #adopt({ session, drop: number, stake, ball: id, seed }) {
    if (this.#which(({ fair }) => fair?.session === session && fair.drop === number).length) return true;
    const ball = id === undefined ? undefined : this.#table?.balls.get(id);
    if (!ball || ball.landed || ball.seed !== seed) return false;
    const ref = `${session}-${number}`;
    const fair = { session, drop: number };
    Object.assign(ball, { mine: true, stake: stake / MINOR_UNITS });
    this.#open.set(ref, { ref, ball, stake: stake / MINOR_UNITS, practice: false, place: this.#hello, fair });
    return true;
  }

  /** @param {string | null | undefined} ref of a drop that the server refused */
  refused(ref) {
    if (this.#open.delete(ref ?? "")) this.news.tell("refused", { ref: ref ?? "" });
  }

  /** A landing was shown. @param {Ball} ball anybody's @param {Landed} outcome */
  seen(ball, outcome) {
    // After a reconnect the page may show again a fall that it has shown before: it must count only once.
    for (const drop of this.#which((each) => each.ball === ball && !each.shown)) this.#see(drop, ball, outcome);
  }

  /** The server has sent a landing. @param {Ball} ball anybody's @param {Landed} landed */
  settled(ball, landed) {
    for (const drop of this.#which((each) => each.ball === ball)) this.#close(drop, ball, landed);
  }

  /**
   * After a disconnect: our balls still fly, or landed meanwhile; if their landings are lost, REST recomputes them.
   * @param {NonNullable<Missed["events"]>} missed
   */
  reclaim(missed) {
    const accepted = missed.filter((event) => event.type === "accepted");
    const landed = missed.filter((event) => event.type === "landed");
    const pending = this.#pending.filter(({ ref }) => this.#open.has(ref));
    this.#pending = [];
    for (const drop of pending) {
      const acceptance = accepted.find(({ ref }) => ref === drop.ref);
      drop.ball ??= acceptingOf(acceptance);
      drop.fair ??= fairPlaceOf(acceptance);
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
    if (flying?.settled && flying.landed) this.#close(drop, ball, flying.landed); // it landed since the hello
    else if (flying) {
      drop.ball = Object.assign(flying, { mine: true, explicit, aim, stake: drop.practice ? undefined : drop.stake });
    } else if (end) this.#close(drop, ball, end);
    else this.#recover(drop, ball);
  }

  /** @param {OwnDrop} drop @param {Accepting} ball whose landing event is lost */
  async #recover(drop, ball) {
    try {
      if (drop.place.mode === "interacting") throw new Error(t("play.knocked"));
      const { seed, x, explicit, aim } = ball;
      const address = { board: this.#addressOf(drop.place), seed, x: explicit ? x : null, aim };
      this.#close(drop, ball, /** @type {DropRecord} */ (await getJson(dropPath(address))));
    } catch {
      this.refused(drop.ref);
      if (drop.fair) this.news.tell("behind", drop.fair.session); // the ledger is asked until it tells the result
      else this.news.say(t("play.unknown"));
    }
  }

  /** @param {OwnDrop} drop @param {Accepting} ball @param {End} end the server's result */
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
  #played({ ref, stake, practice, fair, place }, { seed, x, explicit, aim, by }, { bin, score, digest }) {
    const { mode, board_name: name, board_digest: boardDigest } = place;
    const paid = payoutOf(Math.round(stake * MINOR_UNITS), score) / MINOR_UNITS;
    return {
      board: this.#addressOf(place), boardDigest, name, seed, x: explicit ? x : null, aim: aim ?? null, ref,
      knocked: mode === "interacting", stake, paid, practice, bin, score, digest, ...(fair && { fair }),
      ...(by && { by }),
    };
  }

  /** @param {Hello} hello */
  async #learnAddress(hello) {
    const digest = hello.board_digest;
    if (this.#addresses.has(digest)) return;
    const name = await boardAddress(hello).catch(() => null);
    if (name !== null) this.#addresses.set(digest, name);
  }
}

/**
 * @param {Accepted | BriefAccepted} [event]
 * @returns {FairPlace | undefined} a staked drop's place in its session
 */
export function fairPlaceOf(event) {
  if (!event?.receipt) return undefined;
  const { session, drop } = event.receipt.receipt;
  return { session, drop };
}

/** @param {Accepted} [event] from before the reconnect @returns {Accepting | null} */
function acceptingOf(event) {
  if (!event) return null;
  const { ball: id, seed, x, explicit_x: explicit, aim } = event;
  return { id, seed, x, explicit, aim };
}
