// This player's session at a table: secrets agreed before a drop, receipts kept, and its end.

import { canonical } from "../../fairness/canonical.js";
import { bytesOfHex, hasCrypto, hexOf } from "../../fairness/crypto.js";
import { commitment } from "../../fairness/seeds.js";
import { keepToken } from "../../net/session-token.js";
import { t } from "../../texts/text.js";

/** @import { Receipt, Signed } from "../../fairness/export.js" */
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
 *
 * @typedef {object} FairPlayListener
 * @property {(message: object) => boolean} send
 * @property {() => void} onChange there is another state to show
 * @property {(ended: SessionEnded, heard: Heard) => void} onEnded
 * @property {(ref: string) => void} onRefused a drop that waited for a session goes nowhere
 * @property {(message: string) => void} onFault why there is no session
 * @property {(receipt: Receipt) => void} [onStaked] the server took a drop into the session
 * @property {(session: string, total: number) => void} [onOver] it has had so many drops, and no more
 * @property {(state: SessionState) => void} [onRejoined] it goes on after an absence
 */

/** One player's sessions in one room, one after the other. */
export class FairPlay {
  /** @type {SessionState | null} the one that drops go into */
  state = null;
  /** @type {Kept | null} */
  #kept = null;
  /** @type {{ref: string, message: object}[]} until both secrets are there */
  #waiting = [];
  #secret = "";
  #commitment = "";
  #beginning = false;
  #board = "";
  #failed = false;
  #rejoining = false;

  /** @param {string} room @param {Storage} storage @param {FairPlayListener} listener */
  constructor(room, storage, listener) {
    this.room = room;
    this.storage = storage;
    this.listener = listener;
  }

  get open() {
    return this.state?.open === true && !this.state.ended;
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
  greeted({ board_digest: board, mode }) {
    this.state = null;
    this.#waiting = [];
    this.#beginning = false;
    this.#board = board;
    this.#failed = mode !== "independent";
    if (this.#failed) return;
    const kept = this.#saved().find((each) => each.room === this.room && each.board === board);
    if (!kept) {
      this.#begin();
      return;
    }
    this.#kept = kept;
    this.#secret = kept.secret;
    this.#rejoining = true;
    this.listener.send({ type: "session", session: kept.session, token: kept.token, ref: REF });
  }

  /**
   * A drop into the session: at once, or as soon as it is open.
   * @param {string} ref
   * @param {{stake: number, aim?: number}} drop
   * @returns {boolean} false where there will be no session
   */
  drop(ref, drop) {
    if (this.#failed) return false;
    const message = { type: "drop", ref, ...drop };
    if (this.open) return this.listener.send({ ...message, session: this.state?.session });
    this.#waiting.push({ ref, message });
    return true;
  }

  /** Ends the session, so that it can be checked; another begins by itself. */
  end() {
    if (this.state) this.listener.send({ type: "end", session: this.state.session, ref: REF });
  }

  /** @param {SessionState} state */
  told(state) {
    this.#beginning = false;
    if (!this.#isOurs(state)) {
      this.#give();
      this.listener.onFault(t("fair.not-ours"));
      return;
    }
    this.state = state;
    if (state.token) {
      const { session, token, statement, signature } = state;
      keepToken(this.storage, session, token);
      this.#keep({ room: this.room, board: this.#board, session, token, secret: this.#secret,
        given: { statement, signature }, heard: [] });
    }
    if (!state.token && this.#rejoining) this.listener.onRejoined?.(state);
    this.#rejoining = false;
    if (state.ended) this.listener.onOver?.(state.session, state.drops);
    if (state.ended) this.#begin();
    else if (!state.open) {
      this.listener.send({ type: "open", session: state.session, seed: this.#secret, ref: REF });
    } else this.#flush();
    this.listener.onChange();
  }

  /** @param {SessionEnded} ended */
  ended(ended) {
    const { heard } = this;
    this.listener.onOver?.(ended.session, Number(ended.statement.drops));
    this.#begin();
    this.listener.onEnded(ended, heard);
    this.listener.onChange();
  }

  /** @param {Accepted | BriefAccepted} event whosever */
  accepted({ receipt }) {
    if (!receipt || !this.#kept || receipt.receipt.session !== this.#kept.session) return;
    this.#keep({ ...this.#kept, heard: [...this.#kept.heard, receipt].slice(-HEARD) });
    this.listener.onStaked?.(/** @type {Receipt} */ (receipt.receipt));
    if (this.state) this.state.drops = receipt.receipt.drop + 1;
    if (this.state && this.state.drops >= MOST_DROPS) this.end();
    this.listener.onChange();
  }

  /** @param {Refusal} refusal @returns {boolean} whether it was about the session */
  refused({ ref, code }) {
    const lost = code === "session-state" || code === "unknown-session" || code === "not-yours";
    // Several drops may have gone into a session that was over.
    if (lost && !this.#beginning) this.#begin();
    else if (ref === REF) this.#give();
    return ref === REF && lost;
  }

  async #begin() {
    if (!hasCrypto()) {
      this.#give();
      this.listener.onFault(t("fair.no-crypto"));
      return;
    }
    this.#beginning = true;
    this.state = null;
    this.#kept = null;
    this.#save(this.#saved().filter((each) => each.room !== this.room));
    this.#secret = hexOf(crypto.getRandomValues(new Uint8Array(SECRET_BYTES)));
    this.#commitment = hexOf(await commitment(bytesOfHex(this.#secret, "secret")));
    this.listener.send({ type: "session", commitment: this.#commitment, ref: REF });
  }

  /**
   * Whether the server has committed to what we asked for, and holds to it when we come back.
   * @param {SessionState} state
   */
  #isOurs({ token, statement }) {
    if (!token) return canonical(statement) === canonical(this.#kept?.given.statement ?? null);
    return statement.client_commitment === this.#commitment && statement.room === this.room
      && statement.board_digest === this.#board;
  }

  #flush() {
    const waiting = this.#waiting;
    this.#waiting = [];
    for (const { message } of waiting) {
      this.listener.send({ ...message, session: this.state?.session });
    }
  }

  /** No session can be had: what waited for one goes nowhere. */
  #give() {
    this.#failed = true;
    this.state = null;
    const waiting = this.#waiting;
    this.#waiting = [];
    for (const { ref } of waiting) this.listener.onRefused(ref);
    this.listener.onChange();
  }

  /** @param {Kept} kept */
  #keep(kept) {
    this.#kept = kept;
    this.#save([...this.#saved().filter(({ room }) => room !== this.room), kept].slice(-KEPT));
  }

  /** @returns {Kept[]} */
  #saved() {
    return JSON.parse(this.storage.getItem(KEY) ?? "[]");
  }

  /** @param {Kept[]} all */
  #save(all) {
    this.storage.setItem(KEY, JSON.stringify(all));
  }
}
