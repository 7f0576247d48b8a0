// Over the bin under the pointer: its chance, and what it pays for the present stake. Loaded at the first pointer over
// the board.

import { labelOf } from "../../model/board.js";
import { payoutOf } from "../../model/payout.js";
import { binBox } from "../../paint/board.js";
import { prizeOf } from "../../paint/prizes.js";
import { t } from "../../texts/text.js";
import { make } from "../../util/dom.js";
import { amount, percent } from "../../util/format.js";

/** @import { BoardView } from "../../board/view.js" */
/** @import { Game } from "../game.js" */

const TOUCH_MS = 3500; // that it stays after a tap
const RARE = 0.01; // below this share the tip says "1 of n balls"
const EDGE = 4; // CSS pixels to the board's sides

/** @param {Game} game @param {BoardView} view @param {PointerEvent} first over the board */
export function showBinOdds(game, view, first) {
  const [words, chance] = [make("b"), make("span")];
  const tip = make("p", { class: "bin-odds", role: "status", hidden: "" }, words, chance);
  view.box.append(tip);
  let timer = 0;
  const hide = () => { tip.hidden = true; };

  /** @param {number} bin */
  const fill = (bin) => {
    const { hello } = game.room;
    if (!hello) return;
    const { board, draw } = hello;
    const score = board.bins.multipliers[bin];
    const pays = prizeOf(board, bin, score);
    words.textContent = game.practice || labelOf(board, bin)
      ? pays : t("odds.pays", { pays, paid: amount(payoutOf(Math.round(100 * game.choice.stake), score) / 100) });
    const total = draw?.weights.reduce((sum, weight) => sum + weight, 0) ?? 1;
    const part = draw ? draw.weights[bin] / total : game.odds?.chances[bin];
    chance.hidden = part === undefined;
    if (part === undefined) return;
    if (part === 0) chance.textContent = t("odds.never");
    else if (part < RARE) chance.textContent = t("odds.rare", { n: Math.round(1 / part) });
    else chance.textContent = t("odds.share", { share: percent(part) });
  };

  /** @param {PointerEvent} event */
  const over = (event) => {
    const place = view.aimOf(event);
    const { geometry, board } = view;
    if (!place || !geometry || !board) return;
    const { edges, y } = board.bins;
    const bin = place.y < y ? -1 : edges.findIndex((edge, i) => place.x >= edge && place.x < edges[i + 1]);
    window.clearTimeout(timer);
    if (bin < 0) {
      hide();
      return;
    }
    fill(bin);
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
