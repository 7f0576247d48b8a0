// The name and colour that this visitor has chosen: kept in the browser, sent to rooms. Pure but for storage.

import { textFault } from "../../solver/input/plain-text.js";
import { isRecord, readStored } from "../../util/stored.js";

/** @typedef {{name?: string, colour?: string}} Appearance */

const KEY = "plinko.visitor.1";
const MOST_CHARACTERS = 25; // the server's limit
const MARKUP = /[<>&]/;
const COLOUR = /^#[0-9a-f]{6}$/;

/** @param {string} text as typed @returns {string | null} the name, "" for no name; null if it is not allowed */
export function nameOf(text) {
  const name = text.normalize("NFC").replace(/\s+/g, " ").trim();
  return name && (MARKUP.test(name) || textFault(name, MOST_CHARACTERS)) ? null : name;
}

/** The visitor's appearance, shared by all tabs. */
export class Self {
  /** @param {Pick<Storage, "getItem" | "setItem">} storage */
  constructor(storage) {
    this.storage = storage;
  }

  /** @returns {Appearance} */
  get appearance() {
    const { name, colour } = readStored(this.storage, KEY, isRecord) ?? {};
    return {
      ...(typeof name === "string" && nameOf(name) && { name }),
      ...(typeof colour === "string" && COLOUR.test(colour) && { colour }),
    };
  }

  /** @param {Appearance} chosen an empty string removes the name or the colour */
  change({ name, colour }) {
    this.storage.setItem(KEY, JSON.stringify({ ...(name && { name }), ...(colour && { colour }) }));
  }

  /** @returns {object} the message that is sent to a room */
  get message() {
    return { type: "appear", ...this.appearance };
  }
}
