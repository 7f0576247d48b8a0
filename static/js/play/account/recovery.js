// Finds the results of drops that ended while this page was closed or elsewhere, in the server's ledger.

import { ApiError, getJson } from "../../net/api.js";
import { showingToken } from "../../net/session-token.js";
import { MINOR_UNITS } from "../../model/player/account.js";

/** @import { SessionExport } from "../../fairness/export.js" */
/** @import { AccountEvent, Played } from "../../model/player/account.js" */
/** @import { Wallet } from "./wallet.js" */

const FIRST_WAIT = 1000; // ms until the next request for a session in which a ball still falls
const LONGEST_WAIT = 30_000;
const GONE = [401, 404, 410]; // the token is wrong, or the session does not exist, or its drops were deleted

/**
 * A session's export as events for the account: its drops in order, their results, and the session's end.
 * @param {SessionExport} exported
 * @returns {AccountEvent[]}
 */
function eventsOf(exported) {
  const { session: { statement }, drops, end } = exported;
  const session = String(statement.session);
  const told = drops.flatMap(({ receipt: { drop, stake, room, ball, seed }, result }) => [
    /** @type {AccountEvent} */ ({ type: "staked", session, drop, stake, room, ball, seed }),
    ...(result ? [/** @type {AccountEvent} */ ({
      type: "settled", session, drop, payout: result.payout, played: playedOf(exported, drop),
    })] : []),
  ]);
  return end ? [...told, { type: "over", session, total: drops.length }] : told;
}

/**
 * @param {SessionExport} session
 * @param {number} number the index of a drop that has ended
 * @returns {Played} the drop as the history shows it
 */
function playedOf({ session: { statement }, board, drops }, number) {
  const { receipt, result } = drops[number];
  const { board_digest: digest, seed, aim, stake } = receipt;
  return {
    board: digest, boardDigest: digest, name: String(board.name), seed, x: null, aim,
    stake: stake / MINOR_UNITS, paid: (result?.payout ?? 0) / MINOR_UNITS, practice: false,
    bin: result?.bin ?? null, score: result?.score ?? 1, digest: result?.digest ?? null, fair: { session: String(statement.session), drop: number },
  };
}

/** Requests sessions again and again until all of their drops have ended. */
export class Recovery {
  /** Sessions to be requested once more, because something happened in them during a request. @type {Set<string>} */
  #stale = new Set();
  /** Timers of the next requests, by session; null during one. @type {Map<string, ReturnType<typeof setTimeout> | null>} */
  #asked = new Map();
  /** @type {Map<string, Played[]>} results found so far, by session */
  #found = new Map();

  /**
   * @param {Wallet} wallet
   * @param {{onChange: () => void, onFound: (played: Played[]) => void, onGone: (drops: number) => void}} listener
   *   onFound is called once per session, when all of its drops have ended; onGone when the server does not know
   *   the session any more and its stakes have been refunded
   * @param {(path: string, options: RequestInit) => Promise<unknown>} [ask]
   */
  constructor(wallet, listener, ask = getJson) {
    this.wallet = wallet;
    this.listener = listener;
    this.ask = ask;
  }

  /** @param {Iterable<string>} sessions */
  seek(sessions) {
    for (const session of sessions) {
      if (this.#asked.get(session) === null) this.#stale.add(session);
      if (this.#asked.has(session)) continue;
      void this.#look(session, FIRST_WAIT);
    }
  }

  /** Requests every session with an open drop, except those of the room on screen. @param {string} room */
  seekAllBut(room) {
    this.seek(new Set(this.wallet.open.filter((drop) => drop.room !== room).map(({ session }) => session)));
  }

  /** @param {string} session @param {number} wait ms before the next request */
  async #look(session, wait) {
    this.#asked.set(session, null);
    let failed = false;
    try {
      const path = `sessions/${encodeURIComponent(session)}/export`;
      const shown = showingToken(this.wallet.storage, session);
      // Without the session's token the server would refuse.
      if (shown.headers) this.#take(session, /** @type {SessionExport} */ (await this.ask(path, shown)));
      else this.#refund(session);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      if (GONE.includes(error.status)) this.#refund(session);
      else failed = true;
    }
    const stale = this.#stale.delete(session);
    if (failed || stale || this.wallet.open.some((drop) => drop.session === session)) {
      const again = () => this.#look(session, Math.min(2 * wait, LONGEST_WAIT));
      this.#asked.set(session, setTimeout(again, wait));
      return;
    }
    this.#asked.delete(session);
    const found = this.#found.get(session) ?? [];
    this.#found.delete(session);
    if (found.length) this.listener.onFound(found);
  }

  /** @param {string} session @param {SessionExport} exported */
  #take(session, exported) {
    const news = eventsOf(exported).filter((event) => this.wallet.apply(event));
    const played = news.flatMap((event) => (event.type === "settled" && event.played ? [event.played] : []));
    this.#found.set(session, [...(this.#found.get(session) ?? []), ...played]);
    if (news.length) this.listener.onChange();
  }

  /** Returns the stakes of drops whose results can no longer be found. @param {string} session */
  #refund(session) {
    const lost = this.wallet.open.filter((drop) => drop.session === session);
    for (const { drop, stake } of lost) {
      this.wallet.apply({ type: "settled", session, drop, payout: stake });
    }
    if (lost.length === 0) return;
    this.listener.onGone(lost.length);
    this.listener.onChange();
  }
}
