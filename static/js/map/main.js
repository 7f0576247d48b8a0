// The map page: which bin each start leads to, strip below strip ten times nearer, tile by tile.

import { DEFAULT_BOARD, fillBoards, openPage, showState } from "../board/page.js";
import { ApiError, getJson } from "../net/api.js";
import { t } from "../texts/text.js";
import { byId, fieldOf, inputOf, make } from "../util/dom.js";
import { pixelMiddle, rationalText, readRational } from "./rational.js";

/** @import { Board } from "../model/board.js" */
/** @import { BoardReply } from "../net/replies.js" */

/**
 * @typedef {{x: string, width: string, level: number, first: number, bins: number[],
 *   proofs: number, whole: number}} Tile
 */

const PIXELS = 160; // of a strip
const TILE = 32; // pixels asked for at once
const LEVELS = 31; // down to 1e-30 of the widest
const HUES = 0.82; // of the circle, so that the outermost bins are told apart
const BUSY = new Set([429, 503]);
const PATIENCE = 2000; // ms until a busy server is asked again

class MapPage {
  #proofs = 0;
  #whole = 0;

  /** @param {Board} board @param {string} address @param {string} x */
  constructor(board, address, x) {
    this.board = board;
    this.address = address;
    this.x = x;
  }

  /** Strip by strip, each tile when the one before it is there. */
  async draw() {
    for (let level = 0; level < LEVELS; level += 1) {
      const strip = this.#strip(level);
      for (let first = 0; first < PIXELS; first += TILE) {
        const tile = await this.#tile(level, first);
        this.#paint(strip, tile);
      }
    }
    showState("replay", t("map.map"));
  }

  /** @param {number} level @param {number} first @returns {Promise<Tile>} */
  async #tile(level, first) {
    const query = new URLSearchParams({ x: this.x, level: String(level), first: String(first) });
    const path = `boards/${encodeURIComponent(this.address)}/map?${query}&count=${TILE}`;
    for (;;) {
      try {
        return /** @type {Tile} */ (await getJson(path));
      } catch (error) {
        if (!(error instanceof ApiError) || !BUSY.has(error.status)) throw error;
        await new Promise((done) => { setTimeout(done, PATIENCE); });
      }
    }
  }

  /** @param {number} level @returns {HTMLCanvasElement} an empty strip at the end of the page */
  #strip(level) {
    const canvas = make("canvas", { class: "map-strip", role: "img" });
    [canvas.width, canvas.height] = [PIXELS, 1];
    canvas.dataset.level = String(level);
    canvas.setAttribute("aria-label", t("map.strip", { level }));
    byId("strips").append(make("li", {}, make("span", { class: "map-width" }), canvas));
    return canvas;
  }

  /** @param {HTMLCanvasElement} canvas @param {Tile} tile */
  #paint(canvas, tile) {
    const ctx = canvas.getContext("2d");
    if (!ctx) throw new Error(t("page.no-canvas"));
    tile.bins.forEach((bin, i) => {
      ctx.fillStyle = colourOf(bin, this.board.bins.multipliers.length);
      ctx.fillRect(tile.first + i, 0, 1, 1);
    });
    const width = readRational(tile.width);
    const metres = (Number(width.top) / Number(width.bottom)).toExponential(0);
    const label = canvas.previousElementSibling;
    if (label) label.textContent = `${metres} m`;
    canvas.onclick = (event) => this.#zoom(event, tile);
    this.#proofs += tile.proofs;
    this.#whole += tile.whole;
    byId("result").textContent = t("map.count", { n: this.#proofs, whole: this.#whole });
  }

  /** @param {MouseEvent} event @param {Tile} tile of the strip that was pointed at */
  #zoom(event, tile) {
    const canvas = /** @type {HTMLCanvasElement} */ (event.currentTarget);
    const pixel = Math.floor((event.offsetX / canvas.clientWidth) * PIXELS);
    const x = pixelMiddle(readRational(tile.x), readRational(tile.width), pixel, PIXELS);
    const search = new URLSearchParams({ board: this.address, x: rationalText(x) });
    window.location.assign(`map.html?${search}`);
  }
}

/** @param {number} bin @param {number} bins @returns {string} of CSS */
function colourOf(bin, bins) {
  if (bin === -1) return "white";
  if (bin === -2) return "gray";
  if (bin < 0) return "transparent";
  const hue = (360 * HUES * bin) / Math.max(1, bins - 1);
  return `hsl(${hue} 72% ${bin % 2 ? 62 : 46}%)`;
}

openPage(async () => {
  const search = new URLSearchParams(window.location.search);
  const address = search.get("board") || DEFAULT_BOARD;
  const { board } = /** @type {BoardReply} */ (await getJson(`boards/${encodeURIComponent(address)}`));
  const form = byId("other", HTMLFormElement);
  const x = search.get("x") || "0";
  inputOf(form, "x").value = x;
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const asked = { board: fieldOf(form, "board").value, x: inputOf(form, "x").value.trim() };
    window.location.assign(`map.html?${new URLSearchParams(asked)}`);
  });
  await fillBoards(byId("other-board", HTMLSelectElement), { value: address, name: board.name });
  await new MapPage(board, address, x).draw();
});
