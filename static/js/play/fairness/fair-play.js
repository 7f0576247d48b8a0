// This player's session at a table: secrets agreed before a drop, receipts kept, and its end.

import { canonical } from "../../fairness/canonical.js";
import { bytesOfHex, hasCrypto, hexOf } from "../../fairness/crypto.js";
import { commitment } from "../../fairness/seeds.js";
import { keepToken } from "../../net/session-token.js";
import { t } from "../../texts/text.js";

/** @import { Receipt, Signed } from "../../fairness/export.js" */
/** @import { Store } from "../store.js" */
/** @import { Accepted, BriefAccepted, Hello, Refusal, SessionEnded, SessionState, SignedReceipt } from "../../model/messages.js" */

const REF = "session"; // under which all of it is asked
const SECRET_BYTES = 32;
const KEPT = 8; // rooms whose sessions are found again
const HEARD = 20; // the last receipts: numbers have no gaps, so those before them follow
const KEY = "plinko.fair.2";
const MOST_DROPS = 1000; // of one session, as the server has it

/**
 * What outlives the page, of one room's session.
 * @typedef {{room: string, board: string, session: string, token: string, secret: string,
 *   given: Signed, heard: SignedReceipt[]}} Kept given: what the server had signed before we opened
 *
 * What we were given, as an export has it: the server could change it there.
 * @typedef {{heard: SignedReceipt[], heard_session?: Signed}} Heard
 */

/** One player's sessions in one room, one after the other. */
export class FairPlay {
  /** @type {SessionState | null} the one that drops go into */
  state = null;
  /** @type {Kept | null} */
  #kept = null;
  /** @type {{ref: string, message: object}[]} until both secrets are there, or for the next session */
  #waiting = [];
  /** Drops that the session has been sent and has not answered. @type {Set<string>} */
  #unanswered = new Set();
  /** @type {"no" | "due" | "asked"} it is due until all drops of the session are answered */
  #end = "no";
  #secret = "";
  #commitment = "";
  #beginning = false;
  #board = "";
  /** Digest of the room's draw, if it has one. @type {string | undefined} */
  #draw;
  /** Whether there will be no session: drops are practice. */
  failed = false;
  #rejoining = false;

  /**
   * @param {string} room @param {Pick<Storage, "getItem" | "setItem">} storage
   * @param {Pick<Store, "tell" | "say">} news @param {(message: object) => boolean} send
   */
  constructor(room, storage, news, send) {
    this.room = room;
    this.storage = storage;
    this.news = news;
    this.send = send;
  }

  get open() {
    return this.state?.open === true && !this.state.ended && this.#end === "no";
  }

  /** @returns {string} what the server has committed to, "" before it has */
  get committed() {
    return String(this.state?.statement.server_commitment ?? "");
  }

  /** @returns {Heard} of this session, as it came */
  get heard() {
    return this.#kept ? { heard: this.#kept.heard, heard_session: this.#kept.given } : { heard: [] };
  }

  /** @param {Hello} hello a line is there, or there again: go on with the session, or begin one */
  greeted({ board_digest: board, mode, draw }) {
    this.state = null;
    this.#waiting = [];
    this.#leave();
    this.#beginning = false;
    this.#board = board;
    this.#draw = draw?.digest;
    this.failed = mode !== "independent";
    if (this.failed) return;
    const kept = this.#saved().find((each) => each.room === this.room && each.board === board);
    if (!kept) {
      this.#begin();
      return;
    }
    this.#kept = kept;
    this.#secret = kept.secret;
    this.#rejoining = true;
    this.send({ type: "session", session: kept.session, token: kept.token, ref: REF });
  }

  /**
   * A drop into the session: at once, or as soon as one is open that takes it.
   * @param {string} ref
   * @param {{stake: number, aim?: number}} drop
   * @returns {boolean} false where there will be no session
   */
  drop(ref, drop) {
    if (this.failed) return false;
    const message = { type: "drop", ref, ...drop };
    if (this.#takesMore) return this.#send(ref, message);
    this.#waiting.push({ ref, message });
    return true;
  }

  /** Ends the session, so that it can be checked; another begins by itself, and drops wait for it. */
  end() {
    if (!this.open) return;
    this.#end = "due";
    this.#goOn();
  }

  get #takesMore() {
    return this.open && this.state !== null && this.state.drops + this.#unanswered.size < MOST_DROPS;
  }

  /** @param {string} ref @param {object} message @returns {boolean} */
  #send(ref, message) {
    const sent = this.send({ ...message, session: this.state?.session });
    if (sent) this.#unanswered.add(ref);
    return sent;
  }

  /** Sends what waits, as far as the session takes it; ends a session that is full, or is to end. */
  #goOn() {
    const waiting = this.#waiting;
    this.#waiting = [];
    for (const { ref, message } of waiting) {
      if (this.#takesMore) this.#send(ref, message);
      else this.#waiting.push({ ref, message });
    }
    const { state } = this;
    if (!state || this.#unanswered.size > 0) return;
    if (this.#end === "due" || (this.open && state.drops >= MOST_DROPS)) {
      this.#end = "asked";
      this.send({ type: "end", session: state.session, ref: REF });
    }
  }

  /** Nothing more is to be heard of the session before. */
  #leave() {
    this.#unanswered.clear();
    this.#end = "no";
  }

  /** @param {SessionState} state */
  told(state) {
    this.#beginning = false;
    if (!this.#isOurs(state)) {
      this.#give();
      this.news.say(t("fair.not-ours"), { urgent: true });
      return;
    }
    this.state = state;
    if (state.token) {
      const { session, token, statement, signature } = state;
      keepToken(this.storage, session, token);
      this.#keep({ room: this.room, board: this.#board, session, token, secret: this.#secret,
        given: { statement, signature }, heard: [] });
    }
    if (!state.token && this.#rejoining) this.news.tell("rejoined", state);
    this.#rejoining = false;
    if (state.ended) this.news.tell("over", { session: state.session, total: state.drops });
    if (state.ended) this.#begin();
    else if (!state.open) {
      this.send({ type: "open", session: state.session, seed: this.#secret, ref: REF });
    } else this.#goOn();
    this.news.tell("room", null);
  }

  /** @param {SessionEnded} ended */
  ended(ended) {
    const { heard } = this;
    this.news.tell("over", { session: ended.session, total: Number(ended.statement.drops) });
    // Where a refused drop told us first that it is over, the next one has begun.
    if (ended.session === this.state?.session) this.#begin();
    this.news.tell("ended", { ended, heard });
    this.news.tell("room", null);
  }

  /** @param {Accepted | BriefAccepted} event whosever */
  accepted({ receipt, ref }) {
    if (!receipt || !this.#kept || receipt.receipt.session !== this.#kept.session) return;
    this.#keep({ ...this.#kept, heard: [...this.#kept.heard, receipt].slice(-HEARD) });
    this.news.tell("staked", /** @type {Receipt} */ (receipt.receipt));
    if (this.state) this.state.drops = receipt.receipt.drop + 1;
    this.#unanswered.delete(ref ?? "");
    this.#goOn();
    this.news.tell("room", null);
  }

  /** @param {Pick<Refusal, "ref" | "code">} refusal @returns {boolean} whether it was about the session */
  refused({ ref, code }) {
    const lost = code === "session-state" || code === "unknown-session" || code === "not-yours";
    // Several drops may have gone into a session that was over.
    if (lost && !this.#beginning) this.#begin();
    else if (ref === REF) this.#give();
    else if (this.#unanswered.delete(ref ?? "")) this.#goOn();
    return ref === REF && lost;
  }

  async #begin() {
    if (!hasCrypto()) {
      this.#give();
      this.news.say(t("fair.no-crypto"), { urgent: true });
      return;
    }
    this.#beginning = true;
    this.#leave();
    this.state = null;
    this.#keep(null);
    this.#secret = hexOf(crypto.getRandomValues(new Uint8Array(SECRET_BYTES)));
    this.#commitment = hexOf(await commitment(bytesOfHex(this.#secret, "secret")));
    this.send({ type: "session", commitment: this.#commitment, ref: REF });
  }

  /**
   * Whether the server has committed to what we asked for, and holds to it when we come back.
   * @param {SessionState} state
   */
  #isOurs({ token, statement }) {
    if (!token) return canonical(statement) === canonical(this.#kept?.given.statement ?? null);
    return statement.client_commitment === this.#commitment && statement.room === this.room
      && statement.board_digest === this.#board && statement.draw_digest === this.#draw;
  }

  /** No session can be had: what waited for one goes nowhere. */
  #give() {
    this.failed = true;
    this.state = null;
    const waiting = this.#waiting;
    this.#waiting = [];
    for (const { ref } of waiting) this.news.tell("unsealed", ref);
    this.news.tell("room", null);
  }

  /** @param {Kept | null} kept in the place of what was kept of this room; null forgets */
  #keep(kept) {
    this.#kept = kept;
    const others = this.#saved().filter(({ room }) => room !== this.room);
    this.storage.setItem(KEY, JSON.stringify([...others, ...(kept ? [kept] : [])].slice(-KEPT)));
  }

  /** @returns {Kept[]} */
  #saved() {
    return JSON.parse(this.storage.getItem(KEY) ?? "[]");
  }
}
