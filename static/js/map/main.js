// The map page: colours each start by its bin. Each strip magnifies the one above ten times; tiles load in turn.

import { DEFAULT_BOARD, fillBoards, holdNumber, openPage, showState } from "../board/page.js";
import { ApiError, getJson } from "../net/api.js";
import { t } from "../texts/text.js";
import { contextOf } from "../util/canvas.js";
import { byId, fieldOf, inputOf, make, onSubmit } from "../util/dom.js";
import { fractionOf } from "../util/number-text.js";
import { pixelMiddle, rationalText, readRational } from "./rational.js";

/** @import { Board } from "../model/board.js" */
/** @import { BoardReply } from "../net/replies.js" */

/**
 * @typedef {{x: string, width: string, level: number, first: number, bins: number[],
 *   proofs: number, whole: number}} Tile
 */

const PIXELS = 160; // width of a strip
const TILE = 32; // pixels for each request
const LEVELS = 31; // strips, down to 1e-30 of the first one's width
const HUES = 0.82; // of the colour circle, so that the outermost bins have different colours
const BUSY = new Set([429, 503]);
const RETRY_MS = 2000; // after which a request is repeated if the server was busy

/**
 * Draws strip by strip; each tile is requested when the previous one has arrived.
 * @param {Board} board @param {string} address the board's name in REST paths @param {string} x the middle, m
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

/** @param {string} path @returns {Promise<Tile>} repeats the request while the server is busy */
async function patiently(path) {
  for (;;) {
    try {
      return /** @type {Tile} */ (await getJson(path));
    } catch (error) {
      if (!(error instanceof ApiError) || !BUSY.has(error.status)) throw error;
      await new Promise((done) => { setTimeout(done, RETRY_MS); });
    }
  }
}

/** @param {string} board @param {string} x the middle, m */
function visit(board, x) {
  window.location.assign(`map.html?${new URLSearchParams({ board, x })}`);
}

/** @param {number} bin @param {number} bins @returns {string} a CSS colour */
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
  onSubmit("other", () => {
    const field = inputOf(form, "x");
    if (holdNumber(field, fractionOf)) visit(fieldOf(form, "board").value, field.value || "0");
  });
  await fillBoards(address, board.name);
  await draw(board, address, x);
});
