// What this visitor wants to be called, and in which colour: kept in the browser, told to tables. Pure but for storage.

/** @typedef {{name?: string, colour?: string}} Appearance */

const KEY = "plinko.visitor.1";
const MOST_CHARACTERS = 24; // as the server has it
const HIDDEN = /[<>&\p{C}]/u;
const COLOUR = /^#[0-9a-f]{6}$/;

/** @param {string} text as it was typed @returns {string | null} a name, empty for none; null if it cannot be one */
export function nameOf(text) {
  const name = text.normalize("NFC").replace(/\s+/g, " ").trim();
  return HIDDEN.test(name) || [...name].length > MOST_CHARACTERS ? null : name;
}

/** The same in all tabs, until it is changed. */
export class Self {
  /** @param {Pick<Storage, "getItem" | "setItem">} storage */
  constructor(storage) {
    this.storage = storage;
  }

  /** @returns {Appearance} */
  get appearance() {
    const { name, colour } = /** @type {Appearance} */ (JSON.parse(this.storage.getItem(KEY) ?? "{}"));
    return {
      ...(typeof name === "string" && nameOf(name) && { name }),
      ...(typeof colour === "string" && COLOUR.test(colour) && { colour }),
    };
  }

  /** @param {Appearance} chosen empty texts are none */
  change({ name, colour }) {
    this.storage.setItem(KEY, JSON.stringify({ ...(name && { name }), ...(colour && { colour }) }));
  }

  /** @returns {object} what a table is told */
  get message() {
    return { type: "appear", ...this.appearance };
  }
}
