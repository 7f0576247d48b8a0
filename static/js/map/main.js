// The map page: which bin each start leads to, strip below strip ten times nearer, tile by tile.

import { DEFAULT_BOARD, fillBoards, openPage, showState } from "../board/page.js";
import { ApiError, getJson } from "../net/api.js";
import { t } from "../texts/text.js";
import { contextOf } from "../util/canvas.js";
import { byId, fieldOf, inputOf, make, onSubmit } from "../util/dom.js";
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

/**
 * Strip by strip, each tile when the one before it is there.
 * @param {Board} board @param {string} address what REST calls it @param {string} x of the middle
 */
async function draw(board, address, x) {
  let [proofs, whole] = [0, 0];
  for (let level = 0; level < LEVELS; level += 1) {
    const canvas = make("canvas", { class: "map-strip", role: "img", "aria-label": t("map.strip", { level }) });
    [canvas.width, canvas.height] = [PIXELS, 1];
    canvas.dataset.level = String(level);
    const label = make("span", { class: "map-width" });
    byId("strips").append(make("li", {}, label, canvas));
    const ctx = contextOf(canvas);
    for (let first = 0; first < PIXELS; first += TILE) {
      const query = new URLSearchParams({ x, level: String(level), first: String(first), count: String(TILE) });
      const tile = await patiently(`boards/${encodeURIComponent(address)}/map?${query}`);
      tile.bins.forEach((bin, i) => {
        ctx.fillStyle = colourOf(bin, board.bins.multipliers.length);
        ctx.fillRect(first + i, 0, 1, 1);
      });
      const width = readRational(tile.width);
      label.textContent = `${(Number(width.top) / Number(width.bottom)).toExponential(0)} m`;
      canvas.onclick = ({ offsetX }) => {
        const pixel = Math.floor((offsetX / canvas.clientWidth) * PIXELS);
        visit(address, rationalText(pixelMiddle(readRational(tile.x), width, pixel, PIXELS)));
      };
      proofs += tile.proofs;
      whole += tile.whole;
      byId("result").textContent = t("map.count", { n: proofs, whole });
    }
  }
  showState("replay", t("map.map"));
}

/** @param {string} path @returns {Promise<Tile>} as soon as the server has time for it */
async function patiently(path) {
  for (;;) {
    try {
      return /** @type {Tile} */ (await getJson(path));
    } catch (error) {
      if (!(error instanceof ApiError) || !BUSY.has(error.status)) throw error;
      await new Promise((done) => { setTimeout(done, PATIENCE); });
    }
  }
}

/** @param {string} board @param {string} x of the middle */
function visit(board, x) {
  window.location.assign(`map.html?${new URLSearchParams({ board, x })}`);
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
  onSubmit("other", () => visit(fieldOf(form, "board").value, inputOf(form, "x").value.trim()));
  await fillBoards(address, board.name);
  await draw(board, address, x);
});
