// A pointer over the board: above the pegs it aims and drops, below it picks a ball.

import { aimAt } from "./aim.js";

/** @import { BoardView } from "../../board/view.js" */
/** @import { Game } from "../game.js" */

/** Of one board's canvas. */
export class BoardPointer {
  /** The aim under the pointer, m. @type {number | null} */
  hover = null;

  /** @param {Game} game @param {BoardView} view @param {(x: number, y: number) => void} onPick m */
  constructor(game, view, onPick) {
    this.game = game;
    this.view = view;
    const { moving } = view;
    moving.addEventListener("pointermove", (event) => {
      this.#hover(event.pointerType === "mouse" ? this.#aim(event) : null);
    });
    moving.addEventListener("pointerleave", () => this.#hover(null));
    moving.addEventListener("click", (event) => {
      const place = view.aimOf(event);
      if (place?.above) game.drop(this.#aim(event) ?? undefined);
      else if (place) onPick(place.x, place.y);
    });
  }

  /** @param {MouseEvent} event @returns {number | null} where a ball may start that is dropped there, m */
  #aim(event) {
    const place = this.view.aimOf(event);
    const { hello } = this.game.room;
    return place?.above && hello ? aimAt(hello, place.x) : null;
  }

  /** @param {number | null} x metres */
  #hover(x) {
    if (x === this.hover) return;
    this.hover = x;
    this.view.moving.style.cursor = x === null ? "" : "pointer";
    this.game.tell("picture", null);
  }
}
