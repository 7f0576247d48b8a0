// The rooms this browser has played in, in its storage, for all its tabs.

import { isRecord, readStored } from "../../util/stored.js";

const KEY = "plinko.session.3";
const KEPT = 30;

/** @typedef {{rooms?: Record<string, string>, room?: string}} Saved rooms by their boards' digests */

/** @param {unknown} value @returns {value is Saved} */
function isSaved(value) {
  return isRecord(value) && (value.room === undefined || typeof value.room === "string")
    && (value.rooms === undefined
      || (isRecord(value.rooms) && Object.values(value.rooms).every((room) => typeof room === "string")));
}

/** Rooms opened for boards, and the last room visited. */
export class Visited {
  /** @param {Pick<Storage, "getItem" | "setItem">} storage */
  constructor(storage) {
    this.storage = storage;
  }

  /** @returns {Saved} */
  get #saved() {
    return readStored(this.storage, KEY, isSaved) ?? {};
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
