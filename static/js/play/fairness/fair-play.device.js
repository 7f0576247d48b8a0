// Takes the place of fair-play.js where there is no server: staked drops in a room on this device. The page draws the
// seeds itself and knows every secret, so a seal would prove nothing, and there is none. A session is only what the
// drops of a visit are counted in.

import { ON_DEVICE } from "../../net/device.js";

/** @import { Receipt } from "../../fairness/export.js" */
/** @import { Accepted, BriefAccepted, Hello } from "../../model/messages.js" */
/** @import { Store } from "../store.js" */
/** @import { Heard } from "./fair-play.js" */

/** What a room and its panels use. */
export class FairPlay {
  state = null;
  open = false;
  committed = "";
  failed = false;
  /** @type {Heard} */
  heard = { heard: [] };
  #session = newSession();
  #drops = 0;

  /** @param {string} _ @param {object} __ @param {Pick<Store, "tell">} news @param {(message: object) => boolean} send */
  constructor(_, __, news, send) {
    this.news = news;
    this.send = send;
    window.addEventListener("pagehide", () => this.end());
  }

  /** @param {Hello} hello */
  greeted({ mode }) {
    this.failed = mode !== "independent";
  }

  /** @param {string} ref @param {{stake: number, aim?: number}} drop @returns {boolean} */
  drop(ref, drop) {
    const sent = this.send({ type: "drop", ref, session: this.#session, drop: this.#drops, ...drop });
    if (sent) this.#drops += 1;
    return sent;
  }

  /** @param {Accepted | BriefAccepted} event */
  accepted({ receipt }) {
    if (receipt) this.news.tell("staked", /** @type {Receipt} */ (receipt.receipt));
  }

  /** Ends the session of this visit; further drops begin another. */
  end() {
    if (this.#drops === 0) return;
    this.news.tell("over", { session: this.#session, total: this.#drops });
    this.#session = newSession();
    this.#drops = 0;
  }

  told() {}

  ended() {}

  /** @returns {boolean} */
  refused() {
    return false;
  }
}

/** @returns {string} */
function newSession() {
  return ON_DEVICE + crypto.getRandomValues(new BigUint64Array(1))[0].toString(16);
}
