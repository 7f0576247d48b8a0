// The event bus of the live page: the state announces changes, and each panel subscribes to those that it shows.

/** @import { Hello, QueueState, SessionEnded, SessionState } from "../model/messages.js" */
/** @import { Odds } from "../model/odds.js" */
/** @import { Played } from "../model/player/account.js" */
/** @import { Receipt } from "../fairness/export.js" */
/** @import { Expected } from "./panels/fit.js" */
/** @import { Entry } from "../instruments/pile/columns.js" */
/** @import { Landing, Owner } from "../model/table/visitors.js" */
/** @import { Table } from "../model/table/table.js" */
/** @import { Heard } from "./fairness/fair-play.js" */

/**
 * @typedef {object} News the events' values, by kind
 * @property {{hello: Hello, table: Table}} table a room was entered, or entered again after a lost connection
 * @property {null} room the connection's state, the session or our open drops have changed
 * @property {null} visitors players came, went, changed or landed
 * @property {null} choice the settings on the desk have changed
 * @property {null} account
 * @property {null} run a series of balls has grown or finished
 * @property {Expected | null} expected the distribution that the tray's counts are compared with
 * @property {Odds | null} odds of this room's board; null if unknown
 * @property {null} picture there is something to draw
 * @property {Played} seen the landing of one of our drops was shown: its result is final
 * @property {{bin: number, entry: Entry, owner: Owner | null}} hit anybody's ball has come to lie in a bin
 * @property {Landing} landed the landing of anybody's ball was shown
 * @property {{ref: string}} refused the server refused one of our drops
 * @property {{ref: string, stake: number}[]} adopted balls of ours that were in flight before this page was loaded
 * @property {null} faulty the player wants to drop with an invalid value on the desk
 * @property {{text: string, score?: number, urgent?: boolean}} said for the player; urgent: stays while a ball falls
 * @property {QueueState} queue the drops that wait
 * @property {null} show the room's show has changed
 * @property {import("../model/messages.js").Notice} notice what the operator announces
 * @property {boolean} halted the operator has halted the room, or resumed it
 * @property {{ended: SessionEnded, heard: Heard}} ended a fair session has ended
 * @property {string} unsealed the ref of a drop that waited for a session that failed
 * @property {Receipt} staked the server accepted a drop into a session
 * @property {{session: string, total: number}} over a session takes no more drops; total: the drops that it has had
 * @property {SessionState} rejoined a session was resumed after a reconnect
 * @property {string} behind a session in which drops were accepted or have ended without this page
 * @property {{session: string, drop: number, payout: number}} corrected the server paid another sum than computed
 */

/** Kinds of events that tell a state: who subscribes later receives the last one at once. @type {(keyof News)[]} */
const STATES = ["table", "odds", "ended"];

/** Subscribers by kind of event. */
export class Store {
  /** The last values of STATES. @type {Map<keyof News, unknown>} */
  #last = new Map();
  /** @type {Map<string, ((value: any) => void)[]>} */
  #subscribers = new Map();

  /**
   * @template {keyof News} K
   * @param {K} kind
   * @param {(value: News[K]) => void} subscriber
   */
  on(kind, subscriber) {
    this.#subscribers.set(kind, [...(this.#subscribers.get(kind) ?? []), subscriber]);
    if (this.#last.has(kind)) subscriber(/** @type {News[K]} */ (this.#last.get(kind)));
  }

  /**
   * Collects events of a kind, so that a panel redraws once for many balls.
   * @param {keyof News} kind @param {number} ms from the first event to the call @param {() => void} show
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
    if (STATES.includes(kind)) this.#last.set(kind, value);
    for (const subscriber of this.#subscribers.get(kind) ?? []) subscriber(value);
  }

  /** Shows the player a text. @param {string} text @param {{score?: number, urgent?: boolean}} [how] */
  say(text, how = {}) {
    this.tell("said", { text, ...how });
  }
}
