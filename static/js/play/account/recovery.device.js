// Takes the place of recovery.js where there is no server: computes the results of drops that fell while this page was
// closed or elsewhere.

import { payoutOf } from "../../model/payout.js";
import { knownDrops, MINOR_UNITS } from "../../model/player/account.js";
import { ApiError, getJson } from "../../net/api.js";
import { boardIn, ON_DEVICE, openOnce } from "../../net/device.js";

/** @import { OpenDrop, Played } from "../../model/player/account.js" */
/** @import { BoardReply } from "../../net/replies.js" */
/** @import { Wallet } from "./wallet.js" */

export class Recovery {
  /**
   * @param {Wallet} wallet
   * @param {{onChange: () => void, onFound: (played: Played[]) => void, onGone: (drops: number) => void}} listener
   *   onGone: of drops whose board this device has no more; their stakes are back
   */
  constructor(wallet, listener) {
    this.wallet = wallet;
    this.listener = listener;
  }

  /** @param {Iterable<string>} sessions */
  async seek(sessions) {
    const wanted = new Set([...sessions].filter((session) => session.startsWith(ON_DEVICE)));
    /** @type {Played[]} */
    const found = [];
    let lost = 0;
    for (const drop of this.wallet.open.filter(({ session }) => wanted.has(session))) {
      const played = await this.#computed(drop);
      const { session, drop: number, stake } = drop;
      const payout = played ? Math.round(played.paid * MINOR_UNITS) : stake;
      if (!this.wallet.apply({ type: "settled", session, drop: number, payout, ...(played && { played }) })) continue;
      if (played) found.push(played);
      else lost += 1;
    }
    for (const session of wanted) {
      this.wallet.apply({ type: "over", session, total: knownDrops(this.wallet.account, session) });
    }
    if (found.length > 0) this.listener.onFound(found);
    if (lost > 0) this.listener.onGone(lost);
    if (found.length + lost > 0) this.listener.onChange();
  }

  /** Settles drops in other rooms than this one. @param {string} room */
  seekAllBut(room) {
    void this.seek(this.wallet.open.filter((drop) => drop.room !== room).map(({ session }) => session));
  }

  /** @param {OpenDrop} drop @returns {Promise<Played | null>} null if this device has its board no more */
  async #computed({ session, drop, room, stake, seed, aim = null }) {
    const name = boardIn(room);
    try {
      const reply = /** @type {BoardReply} */ (await getJson(`boards/${encodeURIComponent(name)}`));
      if (seed === undefined) return null;
      const { bin, score, digest } = (await openOnce()).drop(reply.board, { seed, aim });
      return {
        board: name, boardDigest: reply.digest, name: reply.board.name, seed, x: null, aim, stake: stake / MINOR_UNITS,
        paid: payoutOf(stake, score) / MINOR_UNITS, practice: false, bin, score, digest, fair: { session, drop },
      };
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      return null;
    }
  }
}
