// The news of the live page: whoever knows something tells it, and each panel subscribes to what it shows.

/** @import { Hello, QueueState, SessionEnded, SessionState } from "../model/messages.js" */
/** @import { Odds } from "../model/odds.js" */
/** @import { Played } from "../model/player/account.js" */
/** @import { Receipt } from "../fairness/export.js" */
/** @import { Expected } from "./panels/fit.js" */
/** @import { Entry } from "../instruments/pile/columns.js" */
/** @import { Landing, Owner } from "../model/table/company.js" */
/** @import { Ball, Table } from "../model/table/table.js" */
/** @import { Heard } from "./fairness/fair-play.js" */

/**
 * @typedef {object} News by kind
 * @property {{hello: Hello, table: Table}} table a board is there, or there again after a lost line
 * @property {null} room the line's state, the session or our balls in flight are other than before
 * @property {null} company players came, went, changed or landed
 * @property {null} choice the player has set something on the desk
 * @property {null} account
 * @property {null} run what was dropped together has grown, or is down
 * @property {Expected | null} expected what the tray's counts are compared with
 * @property {Odds | null} odds of the table that is played at are known, or that none are
 * @property {null} picture there is something new to draw
 * @property {Played} seen a drop of ours is shown to land: from here on it is final
 * @property {{played: Played, ball: Ball}} landing the same, with the ball that is in the picture
 * @property {{bin: number, entry: Entry, owner: Owner | null}} hit a ball, anybody's, lies in a bin
 * @property {Landing} landed a ball, anybody's, is shown to land
 * @property {{ref: string, text?: string}} refused the table did not take a drop of ours
 * @property {{text: string, score?: number, urgent?: boolean}} said urgent: it stays while a ball falls
 * @property {QueueState} queue what waits to be dropped
 * @property {boolean} halted the operator lets no drops in, or does again
 * @property {{ended: SessionEnded, heard: Heard}} ended a fair session
 * @property {string} unsealed ref of a drop that waited for a session which will not be
 * @property {Receipt} staked the server took a drop into a session
 * @property {{session: string, total: number}} over a session has had so many drops, and no more
 * @property {SessionState} rejoined a session goes on after an absence
 * @property {string} behind a session of which drops have ended, or were taken, without this page
 * @property {{session: string, drop: number, payout: number}} corrected the table paid another sum than was computed
 * @property {number} pong ms that a message took to the server and back
 * @property {null} snapshot balls have new places
 */

/** Subscriptions by kind. */
export class Store {
  /** @type {Map<string, ((value: any) => void)[]>} */
  #subscribers = new Map();

  /**
   * @template {keyof News} K
   * @param {K} kind
   * @param {(value: News[K]) => void} subscriber
   */
  on(kind, subscriber) {
    this.#subscribers.set(kind, [...(this.#subscribers.get(kind) ?? []), subscriber]);
  }

  /**
   * For a panel that shows what is, and need not do so for each of many balls.
   * @param {keyof News} kind @param {number} ms after the first of several @param {() => void} show
   */
  onCalm(kind, ms, show) {
    let timer = 0;
    this.on(kind, () => {
      timer ||= window.setTimeout(() => {
        timer = 0;
        show();
      }, ms);
    });
  }

  /**
   * @template {keyof News} K
   * @param {K} kind
   * @param {News[K]} value
   */
  tell(kind, value) {
    for (const subscriber of this.#subscribers.get(kind) ?? []) subscriber(value);
  }

  /** @param {string} text @param {{score?: number, urgent?: boolean}} [how] for the player to read */
  say(text, how = {}) {
    this.tell("said", { text, ...how });
  }
}
