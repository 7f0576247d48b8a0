// Drops that ended while nobody here watched: what became of them, from the server's ledger.

import { ApiError, getJson } from "../../net/api.js";
import { showingToken } from "../../net/session-token.js";
import { MINOR_UNITS } from "../../model/player/account.js";

/** @import { SessionExport } from "../../fairness/export.js" */
/** @import { AccountEvent, Played } from "../../model/player/account.js" */
/** @import { Wallet } from "./wallet.js" */

const FIRST_WAIT = 1000; // ms until a session is asked for again in which a ball falls
const LONGEST_WAIT = 30_000;
const GONE = [401, 404]; // no token here that opens it, or no such session

/**
 * What an export tells an account: drops in order, how each has ended, and whether more can come.
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
 * @param {number} number of a drop that has ended
 * @returns {Played} as the history has it
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

/** Asks for sessions until nothing falls in them any more. */
export class Recovery {
  /** @type {Map<string, ReturnType<typeof setTimeout> | null>} sessions that are being asked for */
  #asked = new Map();
  /** @type {Map<string, Played[]>} what they have told until now */
  #found = new Map();

  /**
   * @param {Wallet} wallet
   * @param {{onChange: () => void, onFound: (played: Played[]) => void, onGone: (drops: number) => void}} listener
   *   onFound: of a session, once all of it is known; onGone: stakes are back, as nobody knows of their drops
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
      if (this.#asked.has(session)) continue;
      this.#asked.set(session, null);
      this.#look(session, FIRST_WAIT);
    }
  }

  /** Every session with a drop whose end is unknown, but for those of a room that is watched. @param {string} room */
  seekAllBut(room) {
    this.seek(new Set(this.wallet.open.filter((drop) => drop.room !== room).map(({ session }) => session)));
  }

  /** @param {string} session @param {number} wait ms before the next look */
  async #look(session, wait) {
    try {
      const path = `sessions/${encodeURIComponent(session)}/export`;
      const shown = showingToken(this.wallet.storage, session);
      // Without its token the server would only refuse.
      if (shown.headers) this.#take(session, /** @type {SessionExport} */ (await this.ask(path, shown)));
      else this.#refund(session);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      if (GONE.includes(error.status)) this.#refund(session);
    }
    if (this.wallet.open.some((drop) => drop.session === session)) {
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

  /** Nobody can say any more what became of these. @param {string} session */
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
