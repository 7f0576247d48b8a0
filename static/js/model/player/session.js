// What this visitor has played: score and last drops, kept by the browser for all its tabs.

import { Mean } from "../statistics.js";

const KEY = "plinko.session.3";
const KEPT = 30;

/**
 * @typedef {{session: string, drop: number}} FairPlace a session, and a drop's number there
 *
 * @typedef {object} Played
 * @property {string} board a preset's name or a digest, as REST takes it
 * @property {string} name what the board calls itself
 * @property {string} seed decimal
 * @property {number | null} x explicit start in metres, null when the seed drew it
 * @property {number | null} [aim] middle of what the seed drew, metres, where the player chose it
 * @property {number | null} bin null when it never settled
 * @property {number} score what a stake of one came back as
 * @property {boolean} [knocked] others may have touched the ball: its seed alone says nothing
 * @property {number} [stake] 1 unless it was more
 * @property {string | null} [digest] the drop's, or its first digits, as the table told it
 * @property {string} [boardDigest]
 * @property {FairPlace} [fair] of a staked drop
 * @property {boolean} [practice] its seed was chosen, or it fell in this page alone: it counts for nothing
 */

/** Score and history, saved after each change so that a replay's reload loses nothing. */
export class Session {
  staked = 0;
  returned = 0;
  /** @type {Played[]} newest first */
  last = [];
  /** Of all scores, each drop counting alike whatever was staked on it. */
  scores = new Mean();
  /** Rooms that were opened for a board, by its digest. @type {Record<string, string>} */
  rooms = {};
  /** Where this visitor last played, so that a replay leads back there. */
  room = "";

  #text = "";

  /** @param {Pick<Storage, "getItem" | "setItem">} storage */
  constructor(storage) {
    this.storage = storage;
    this.refresh();
  }

  /** Reads what another tab has written. */
  refresh() {
    const saved = this.storage.getItem(KEY);
    if (saved === null || saved === this.#text) return;
    this.#text = saved;
    const { scores, ...rest } = JSON.parse(saved);
    Object.assign(this, rest, { scores: new Mean(scores) });
  }

  get net() {
    return this.returned - this.staked;
  }

  /** @param {Played} drop settled; its stake counts from here on */
  settle(drop) {
    this.refresh();
    const { stake = 1, score, practice = false } = drop;
    if (!practice) {
      this.staked += stake;
      this.returned += stake * score;
      this.scores.add(score);
    }
    this.last = [drop, ...this.last].slice(0, KEPT);
    this.#save();
  }

  /** @param {string} room */
  enter(room) {
    this.refresh();
    this.room = room;
    this.#save();
  }

  /** @param {string} digest of a board @param {string} room where it is played */
  remember(digest, room) {
    this.refresh();
    const rooms = Object.entries({ ...this.rooms, [digest]: room });
    this.rooms = Object.fromEntries(rooms.slice(-KEPT));
    this.#save();
  }

  clear() {
    this.staked = 0;
    this.returned = 0;
    this.scores = new Mean();
    this.last = [];
    this.#save();
  }

  #save() {
    const { staked, returned, last, scores, rooms, room } = this;
    this.#text = JSON.stringify({ staked, returned, last, scores, rooms, room });
    this.storage.setItem(KEY, this.#text);
  }
}
