// The pointer on the board: above the pegs it aims and drops; over a bin it shows the bin's odds.

import { aimAt } from "./aim.js";

/** @import { BoardView } from "../../board/view.js" */
/** @import { Game } from "../game.js" */

/**
 * Listens to a board's canvas.
 * @param {Game} game @param {BoardView} view
 * @returns {() => number | null} the aim under the pointer, m
 */
export function followPointer(game, view) {
  /** @type {number | null} */
  let hover = null;
  const { moving } = view;
  /** @param {MouseEvent} event @returns {number | null} the nearest allowed aim, m */
  const aim = (event) => {
    const place = view.aimOf(event);
    const { hello } = game.room;
    return place?.above && hello ? aimAt(hello, place.x) : null;
  };
  /** @param {number | null} x m */
  const show = (x) => {
    if (x === hover) return;
    hover = x;
    moving.style.cursor = x === null ? "" : "pointer";
    game.tell("picture", null);
  };
  moving.addEventListener("pointermove", (event) => show(event.pointerType === "mouse" ? aim(event) : null));
  moving.addEventListener("pointerleave", () => show(null));
  let asked = false;
  /** Loads the odds for the first pointer over a bin. @param {PointerEvent} event */
  const overBins = async (event) => {
    const place = view.aimOf(event);
    if (asked || !place || !view.board || place.y < view.board.bins.y) return;
    asked = true;
    const odds = await import("../panels/bin-odds.js").catch(() => null);
    asked = odds !== null; // else the next one tries again
    odds?.showBinOdds(game, view, event);
  };
  for (const kind of /** @type {const} */ (["pointermove", "pointerdown"])) moving.addEventListener(kind, overBins);
  moving.addEventListener("click", (event) => {
    if (view.aimOf(event)?.above) game.drop(aim(event) ?? undefined);
  });
  return () => hover;
}
