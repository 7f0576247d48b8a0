// This player's fair session in a room: both secrets committed before a drop, the receipts, and the session's end.
//
// The messages of one session, in order:
//   session   the page commits to its secret; the server answers with a signed statement that contains both commitments
//   open      only now the page sends its secret, so the server cannot have chosen its own secret by it
//   drop      each accepted drop comes back with a signed receipt
//   end       once all drops are answered, the server reveals its secret, and the session can be checked
// The next session begins at once. Drops made in between wait for it.

import { canonical } from "../../fairness/canonical.js";
import { bytesOfHex, hasCrypto, hexOf } from "../../fairness/crypto.js";
import { commitment } from "../../fairness/seeds.js";
import { keepToken, tokenOf } from "../../net/session-token.js";
import { t } from "../../texts/text.js";
import { isRecord, readStored } from "../../util/stored.js";

/** @import { Receipt, Signed } from "../../fairness/export.js" */
/** @import { Store } from "../store.js" */
/** @import { Accepted, BriefAccepted, Hello, Refusal, SessionEnded, SessionState, SignedReceipt } from "../../model/messages.js" */

const REF = "session"; // the ref of every message about the session itself
const SECRET_BYTES = 32;
const KEPT = 8; // rooms whose sessions can be resumed
const HEARD = 20; // receipts kept: drop numbers have no gaps, so the last ones imply those before
const KEY = "plinko.fair.2";
const MOST_DROPS = 1000; // a session: the server's limit

/**
 * What is stored of one room's session, to resume it after a reload. `given` is the statement that the server had
 * signed before we opened the session.
 * @typedef {{room: string, board: string, session: string, secret: string, given: Signed,
 *   heard: SignedReceipt[]}} Kept
 *
 * What this page itself has received, in an export's format. The check compares it with the server's export, which
 * the server could have changed.
 * @typedef {{heard: SignedReceipt[], heard_session?: Signed}} Heard
 */

/** One player's sessions in one room, one after the other. */
export class FairPlay {
  /** @type {SessionState | null} the session that drops go into */
  state = null;
  /** @type {Kept | null} */
  #kept = null;
  /** @type {{ref: string, message: object}[]} drops that wait until the session, or the next one, is open */
  #waiting = [];
  /** Refs of drops sent into the session and not answered yet. @type {Set<string>} */
  #unanswered = new Set();
  /** @type {"no" | "due" | "asked"} the end stays due until all drops sent into the session are answered */
  #end = "no";
  #secret = "";
  #commitment = "";
  #beginning = false;
  #board = "";
  /** Digest of the room's draw, if it has one. @type {string | undefined} */
  #draw;
  /** Whether no session is possible: drops are practice. */
  failed = false;
  #rejoining = false;

  /**
   * @param {string} room @param {Pick<Storage, "getItem" | "setItem" | "removeItem">} storage
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

  /** @returns {string} the server's commitment, "" before there is one */
  get committed() {
    return String(this.state?.statement.server_commitment ?? "");
  }

  /** @returns {Heard} what this page has received of the session, unchanged */
  get heard() {
    return this.#kept ? { heard: this.#kept.heard, heard_session: this.#kept.given } : { heard: [] };
  }

  /**
   * A connection is open, or open again, or its room was reset: resumes the stored session, or begins one.
   * @param {Hello} hello
   * @param {boolean} [held] whether the connection is still the same: then the server answers what was sent before
   */
  greeted({ board_digest: board, mode, draw }, held = false) {
    if (held && board === this.#board && this.#beginning) return; // the session that was asked for is of this board
    this.state = null;
    const waiting = this.#waiting;
    this.#waiting = [];
    if (held && mode === "independent" && board === this.#board) this.#waiting = waiting;
    else if (held) for (const { ref } of waiting) this.news.tell("unsealed", ref);
    if (!held) this.#leave();
    this.#beginning = false;
    this.#board = board;
    this.#draw = draw?.digest;
    this.failed = mode !== "independent";
    if (this.failed) return;
    // What is stored may be another tab's session.
    const kept = this.#kept ?? this.#saved().find((each) => each.room === this.room) ?? null;
    this.#kept = kept;
    const token = kept && tokenOf(this.storage, kept.session);
    if (!kept || kept.board !== board || !token) {
      this.#abandon();
      return;
    }
    this.#secret = kept.secret;
    this.#rejoining = true;
    this.send({ type: "session", session: kept.session, token, ref: REF });
  }

  /**
   * Sends a drop into the session: at once, or as soon as a session is open that has room for it.
   * @param {string} ref
   * @param {{stake: number, aim?: number}} drop
   * @returns {boolean} false where no session is possible
   */
  drop(ref, drop) {
    if (this.failed) return false;
    const message = { type: "drop", ref, ...drop };
    if (this.#takesMore) return this.#send(ref, message);
    this.#waiting.push({ ref, message });
    return true;
  }

  /** Ends the session, so that it can be checked. The next one begins by itself; drops made meanwhile wait for it. */
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

  /** Sends waiting drops while the session has room for them. Ends a session that is full, or whose end is due. */
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

  /** Forgets the previous session: no more answers will come from it. */
  #leave() {
    this.#unanswered.clear();
    this.#end = "no";
  }

  /** @param {SessionState} state */
  told(state) {
    this.#beginning = false;
    if (!this.#isOurs(state)) {
      this.#giveUp();
      this.news.say(t("fair.not-ours"), { urgent: true });
      return;
    }
    this.state = state;
    if (state.token) {
      const { session, token, statement, signature } = state;
      keepToken(this.storage, session, token);
      this.#keep({ room: this.room, board: this.#board, session, secret: this.#secret,
        given: { statement, signature }, heard: [] });
    }
    if (!state.token && this.#rejoining) this.news.tell("rejoined", state);
    this.#rejoining = false;
    if (state.void) this.news.say(t("fair.void"), { urgent: true });
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
    // A refused drop may have shown before that this session is over; then the next one has already begun.
    if (ended.session === this.state?.session) this.#begin();
    this.news.tell("ended", { ended, heard });
    this.news.tell("room", null);
  }

  /** @param {Accepted | BriefAccepted} event of anybody's drop */
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
    // Several drops may have been sent into a session that was over: only the first refusal begins a new one.
    if (lost && !this.#beginning) this.#abandon();
    else if (ref === REF) this.#giveUp();
    else if (this.#unanswered.delete(ref ?? "")) this.#goOn();
    return ref === REF && lost;
  }

  /** Begins a session in place of one whose end this page has not received: it may have drops that are not known here. */
  #abandon() {
    if (this.#kept) this.news.tell("behind", this.#kept.session);
    void this.#begin();
  }

  async #begin() {
    if (!hasCrypto()) {
      this.#giveUp();
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
   * Whether the server's statement is about the session that we asked for or, after a reconnect, is the one that it
   * signed at the beginning.
   * @param {SessionState} state
   */
  #isOurs({ token, statement }) {
    if (!token) return canonical(statement) === canonical(this.#kept?.given.statement ?? null);
    return statement.client_commitment === this.#commitment && statement.room === this.room
      && statement.board_digest === this.#board && statement.draw_digest === this.#draw;
  }

  /** No session is possible: gives up the drops that waited for one. */
  #giveUp() {
    this.failed = true;
    this.state = null;
    const waiting = this.#waiting;
    this.#waiting = [];
    for (const { ref } of waiting) this.news.tell("unsealed", ref);
    this.news.tell("room", null);
  }

  /** @param {Kept | null} kept replaces what was stored of this room; null deletes it */
  #keep(kept) {
    this.#kept = kept;
    const others = this.#saved().filter(({ room }) => room !== this.room);
    this.storage.setItem(KEY, JSON.stringify([...others, ...(kept ? [kept] : [])].slice(-KEPT)));
  }

  /** @returns {Kept[]} */
  #saved() {
    return readStored(this.storage, KEY, isAllKept) ?? [];
  }
}

/** @param {unknown} value @returns {value is Kept[]} */
function isAllKept(value) {
  return Array.isArray(value) && value.every((kept) => isRecord(kept) && isRecord(kept.given)
    && isRecord(kept.given.statement) && Array.isArray(kept.heard)
    && ["room", "board", "session", "secret"].every((name) => typeof kept[name] === "string"));
}
