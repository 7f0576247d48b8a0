// What this visitor has played: score and last drops, kept while the tab lives.

const KEY = "plinko.session.1";
const KEPT = 30;

/**
 * @typedef {object} Played
 * @property {string} board a preset's name or a digest, as REST takes it
 * @property {string} name what the board calls itself
 * @property {string} seed decimal
 * @property {number | null} x explicit start in metres, null when the seed decided
 * @property {number | null} bin null when it never settled
 * @property {number} score what one stake came back as
 */

/** Score and history, saved after each change so that a replay's reload loses nothing. */
export class Session {
  staked = 0;
  returned = 0;
  /** @type {Played[]} newest first */
  last = [];
  /** Where this visitor last played, so that a replay leads back there. */
  room = "";

  /** @param {Storage} storage */
  constructor(storage) {
    this.storage = storage;
    const saved = storage.getItem(KEY);
    if (saved !== null) Object.assign(this, JSON.parse(saved));
  }

  get net() {
    return this.returned - this.staked;
  }

  /** @param {Played} drop settled; its stake of 1 counts from here on */
  settle(drop) {
    this.staked += 1;
    this.returned += drop.score;
    this.last = [drop, ...this.last].slice(0, KEPT);
    this.#save();
  }

  /** @param {string} room */
  enter(room) {
    this.room = room;
    this.#save();
  }

  clear() {
    this.staked = 0;
    this.returned = 0;
    this.last = [];
    this.#save();
  }

  #save() {
    const { staked, returned, last, room } = this;
    this.storage.setItem(KEY, JSON.stringify({ staked, returned, last, room }));
  }
}
