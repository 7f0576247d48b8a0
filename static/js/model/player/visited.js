// The rooms this browser has played in, in its storage, for all its tabs.

const KEY = "plinko.session.3";
const KEPT = 30;

/** Rooms opened for boards, and the last room visited. */
export class Visited {
  /** @param {Pick<Storage, "getItem" | "setItem">} storage */
  constructor(storage) {
    this.storage = storage;
  }

  /** @returns {{rooms?: Record<string, string>, room?: string}} rooms by their boards' digests */
  get #saved() {
    return JSON.parse(this.storage.getItem(KEY) ?? "{}");
  }

  get rooms() {
    return this.#saved.rooms ?? {};
  }

  /** The last room visited, which a replay links back to. */
  get room() {
    return this.#saved.room ?? "";
  }

  /** @param {string} room */
  enter(room) {
    this.#save({ rooms: this.rooms, room });
  }

  /** @param {string} digest of a board @param {string} room where it is played */
  remember(digest, room) {
    const rooms = Object.entries({ ...this.rooms, [digest]: room }).slice(-KEPT);
    this.#save({ rooms: Object.fromEntries(rooms), room: this.room });
  }

  /** @param {{rooms: Record<string, string>, room: string}} saved */
  #save(saved) {
    this.storage.setItem(KEY, JSON.stringify(saved));
  }
}
