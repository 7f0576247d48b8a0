// What the page shows of the account and allows by it: balance, refill, stakes that can be paid.

import { payoutOf } from "../../fairness/payout.js";
import { t } from "../../texts/text.js";
import { byId } from "../../util/dom.js";
import { amount } from "../../util/format.js";
import { MINOR_UNITS } from "../own-drops.js";
import { Recovery } from "./recovery.js";

/** @import { Played, Session } from "../../model/player/session.js" */
/** @import { Ask } from "../input/controls.js" */
/** @import { LiveTable } from "../live.js" */
/** @import { Wallet } from "./wallet.js" */

/**
 * @typedef {object} CreditsListener
 * @property {(played: Played) => void} onFound a drop had ended while nobody watched
 * @property {() => void} onChange there is something new to show
 * @property {(text: string) => void} say
 */

/** Credits of the visitor, shared with all other tabs of the browser. */
export class Credits {
  /** @param {Session} session @param {Wallet} wallet @param {CreditsListener} listener */
  constructor(session, wallet, listener) {
    this.session = session;
    this.wallet = wallet;
    this.listener = listener;
    this.recovery = new Recovery(wallet, {
      onFound: (played) => {
        session.settle(played);
        listener.onFound(played);
      },
      onChange: listener.onChange,
      onGone: listener.say,
    });
    byId("refill").addEventListener("click", () => {
      wallet.refill();
      this.show();
      listener.say(t("play.refilled", { balance: this.#balance }));
    });
    window.addEventListener("storage", () => {
      session.refresh();
      listener.onChange();
    });
    this.show();
  }

  /** @param {Played} played counts unless it did already, here or in another tab */
  settle(played) {
    const { fair, stake = 0, score } = played;
    if (fair) {
      const payout = payoutOf(Math.round(stake * MINOR_UNITS), score);
      if (!this.wallet.apply({ type: "settled", ...fair, payout })) return;
    }
    this.session.settle(played);
  }

  /**
   * @param {Ask} ask
   * @param {LiveTable} live
   * @returns {boolean} false, and why is said, when there are too few credits
   */
  allow({ seed, stake }, { takesStakes, own }) {
    if (seed !== null || !takesStakes) return true;
    const free = this.wallet.balance - Math.round(own.held * MINOR_UNITS);
    if (Math.round(stake * MINOR_UNITS) <= free) return true;
    const { canRefill } = this.wallet;
    this.show();
    const told = { stake: amount(stake), free: amount(free / MINOR_UNITS) };
    this.listener.say(canRefill ? t("play.too-few-refill", told) : t("play.too-few", told));
    return false;
  }

  get #balance() {
    return amount(this.wallet.balance / MINOR_UNITS);
  }

  show() {
    byId("balance").textContent = this.#balance;
    byId("refill").hidden = !this.wallet.canRefill;
  }
}
