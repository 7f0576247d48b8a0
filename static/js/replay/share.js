// What a drop is shared as: a link, a frame for other sites, a poster, a film, its record.

import { dropPath, dropSearch } from "../net/drop-address.js";
import { byId } from "../util/dom.js";

/** @import { DropAddress } from "../net/drop-address.js" */

const POSTER_WIDTH = "1200"; // pixels
const FILM_WIDTH = "480";
const FRAME = { width: 520, height: 580 }; // CSS pixels, for a board about as wide as high

/** The panel that hands a drop on. Nothing works before `load`. */
export class Share {
  constructor() {
    this.text = byId("share-text", HTMLInputElement);
    this.note = byId("share-note");
    this.link = "";
    this.frame = "";
    this.buttons = ["share-link", "share-frame"].map((id) => byId(id, HTMLButtonElement));
    this.buttons[0].addEventListener("click", () => this.#copy(this.link, "The link"));
    this.buttons[1].addEventListener("click", () => this.#copy(this.frame, "The HTML"));
  }

  /**
   * @param {DropAddress} drop
   * @param {string} hash of the address, which may hold the board
   */
  load(drop, hash) {
    const search = dropSearch({ ...drop, board: hash ? "" : drop.board });
    const at = (/** @type {string} */ path) => new URL(`${path}?${search}${hash}`, document.baseURI).href;
    this.link = new URL(`replay.html?${search}&guess${hash}`, document.baseURI).href;
    this.frame = frameOf(at("embed/replay"), `Seed ${drop.seed}`);
    const api = (/** @type {string} */ part, /** @type {Record<string, string>} */ query = {}) =>
      `api/v1/${dropPath(drop, part, new URLSearchParams(query))}`;
    byId("share-poster", HTMLAnchorElement).href = api(".png", { width: POSTER_WIDTH });
    byId("share-film", HTMLAnchorElement).href = api(".webp", { width: FILM_WIDTH });
    byId("share-record", HTMLAnchorElement).href = api("");
    const name = `plinko-${drop.seed}`;
    byId("share-poster", HTMLAnchorElement).download = `${name}.png`;
    byId("share-film", HTMLAnchorElement).download = `${name}.webp`;
    byId("share-record", HTMLAnchorElement).download = `${name}.json`;
    for (const button of this.buttons) button.disabled = false;
  }

  /** @param {string} text @param {string} what it is, in words */
  async #copy(text, what) {
    this.text.hidden = false;
    this.text.value = text;
    this.text.select();
    try {
      await navigator.clipboard.writeText(text);
      this.note.textContent = `${what} is copied.`;
    } catch {
      // Without permission, or on a page that came by plain HTTP: it is marked, ready for the keys.
      this.note.textContent = `${what} is marked above; copy it from there.`;
    }
  }
}

/** @param {string} address @param {string} title @returns {string} HTML that shows it in a frame */
export function frameOf(address, title) {
  const source = address.replaceAll("&", "&amp;").replaceAll('"', "&quot;");
  const { width, height } = FRAME;
  return `<iframe src="${source}" title="${title} – Plinko" width="${width}" height="${height}" `
    + 'style="border:0" loading="lazy"></iframe>';
}
