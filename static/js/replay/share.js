// What a drop is shared as: a link, a frame for other sites, a poster, a film, its record.

import { messageOf, request } from "../net/api.js";
import { dropPath, dropSearch } from "../net/drop-address.js";
import { t } from "../texts/text.js";
import { copyFrom } from "../util/copy.js";
import { byId } from "../util/dom.js";
import { saveFile } from "../util/file.js";

/** @import { DropAddress } from "../net/drop-address.js" */

const POSTER_WIDTH = "1200"; // pixels
const FILM_WIDTH = "480";
/** @type {[string, string, string, Record<string, string>][]} link, path below the drop's, its file's end, query */
const FILES = [
  ["share-poster", ".png", ".png", { width: POSTER_WIDTH }], ["share-film", ".webp", ".webp", { width: FILM_WIDTH }],
  ["share-record", "", ".json", {}],
];
const FRAME = { width: 520, height: 580 }; // CSS pixels, for a board about as wide as high

/** The panel that hands a drop on. Nothing works before `load`. */
export class Share {
  constructor() {
    this.text = byId("share-text", HTMLInputElement);
    this.note = byId("share-note");
    this.link = "";
    this.frame = "";
    this.video = { path: "", name: "" };
    this.buttons = ["share-link", "share-frame", "share-video"].map((id) => byId(id, HTMLButtonElement));
    this.buttons[0].addEventListener("click", () => this.#copy(this.link, { copied: t("replay.link-copied"), marked: t("replay.link-marked") }));
    this.buttons[2].addEventListener("click", () => this.#saveVideo());
    this.buttons[1].addEventListener("click", () => this.#copy(this.frame, { copied: t("replay.frame-copied"), marked: t("replay.frame-marked") }));
  }

  /**
   * @param {DropAddress} drop
   * @param {string} hash of the address, which may hold the board
   */
  load(drop, hash) {
    const search = dropSearch({ ...drop, board: hash ? "" : drop.board });
    const at = (/** @type {string} */ path) => new URL(`${path}?${search}${hash}`, document.baseURI).href;
    this.link = new URL(`replay.html?${search}&guess${hash}`, document.baseURI).href;
    this.frame = frameOf(at("embed/replay"), t("replay.frame-title", { seed: drop.seed }));
    const name = `plinko-${drop.seed}`;
    for (const [id, part, end, query] of FILES) {
      const link = byId(id, HTMLAnchorElement);
      link.href = `api/v1/${dropPath(drop, part, new URLSearchParams(query))}`;
      link.download = `${name}${end}`;
    }
    this.video = { path: dropPath(drop, ".mp4", new URLSearchParams({ width: FILM_WIDTH })), name: `${name}.mp4` };
    for (const button of this.buttons) button.disabled = false;
  }

  /** Asked for by a script and not by a link: not every server can, and why is said in words. */
  async #saveVideo() {
    const { path, name } = this.video;
    const button = this.buttons[2];
    button.disabled = true;
    this.note.textContent = t("page.computing");
    try {
      const reply = await request(path);
      saveFile(name, await reply.blob(), "video/mp4");
      this.note.textContent = t("replay.share-note");
    } catch (error) {
      this.note.textContent = messageOf(error);
    }
    button.disabled = false;
  }

  /** @param {string} text @param {{copied: string, marked: string}} words for either end */
  async #copy(text, { copied, marked }) {
    this.note.textContent = (await copyFrom(this.text, text)) ? copied : marked;
  }
}

/** @param {string} address @param {string} title @returns {string} HTML that shows it in a frame */
export function frameOf(address, title) {
  const source = address.replaceAll("&", "&amp;").replaceAll('"', "&quot;");
  const { width, height } = FRAME;
  return `<iframe src="${source}" title="${title} – Plinko" width="${width}" height="${height}" `
    + 'style="border:0" loading="lazy"></iframe>';
}
