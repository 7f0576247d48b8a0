// Over the bin under the pointer: its chance, and what it pays for the present stake. Loaded at the first pointer over
// the board.

import { binBox } from "../../paint/board.js";
import { make } from "../../util/dom.js";
import { binWords } from "./bin-words.js";

/** @import { BoardView } from "../../board/view.js" */
/** @import { Game } from "../game.js" */

const TOUCH_MS = 3500; // that it stays after a tap
const EDGE = 4; // CSS pixels to the board's sides

/** @param {Game} game @param {BoardView} view @param {PointerEvent} first over the board */
export function showBinOdds(game, view, first) {
  const [words, chance] = [make("b"), make("span")];
  const tip = make("p", { class: "bin-odds", role: "status", hidden: "" }, words, chance);
  view.box.append(tip);
  let timer = 0;
  const hide = () => { tip.hidden = true; };

  /** @param {PointerEvent} event */
  const over = (event) => {
    const place = view.aimOf(event);
    const { geometry, board } = view;
    const { hello } = game.room;
    if (!place || !geometry || !board || !hello) return;
    const { edges, y } = board.bins;
    const bin = place.y < y ? -1 : edges.findIndex((edge, i) => place.x >= edge && place.x < edges[i + 1]);
    window.clearTimeout(timer);
    if (bin < 0) {
      hide();
      return;
    }
    [words.textContent, chance.textContent] = binWords(game, hello, bin);
    tip.hidden = false;
    const box = binBox(geometry, board, bin);
    const half = tip.offsetWidth / 2 + EDGE;
    const middle = Math.max(half, Math.min(geometry.width - half, box.x + box.width / 2));
    Object.assign(tip.style, { left: `${middle}px`, top: `${box.y}px` });
    if (event.pointerType !== "mouse") timer = window.setTimeout(hide, TOUCH_MS);
  };
  view.moving.addEventListener("pointermove", over);
  view.moving.addEventListener("pointerdown", over);
  view.moving.addEventListener("pointerleave", ({ pointerType }) => { if (pointerType === "mouse") hide(); });
  game.on("table", hide);
  over(first);
}
