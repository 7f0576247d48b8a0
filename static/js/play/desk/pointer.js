// A pointer over the board: above the pegs it aims and drops, below it picks a ball.

/** @import { BoardView } from "../../board/view.js" */

/**
 * @typedef {object} BoardPointerListener metres
 * @property {(x: number) => number | null} aimAt where a ball may start that is dropped there
 * @property {(x: number | null) => void} onDrop null: where the board has balls start
 * @property {(x: number, y: number) => void} onPick
 * @property {() => void} onHover the aim under the pointer is another
 */

/** Of one board's canvas. */
export class BoardPointer {
  /** The aim under the pointer, m. @type {number | null} */
  hover = null;

  /** @param {BoardView} view @param {BoardPointerListener} listener */
  constructor(view, listener) {
    this.view = view;
    this.listener = listener;
    const { moving } = view;
    moving.addEventListener("pointermove", (event) => {
      this.#hover(event.pointerType === "mouse" ? this.#aim(event) : null);
    });
    moving.addEventListener("pointerleave", () => this.#hover(null));
    moving.addEventListener("click", (event) => {
      const place = view.aimOf(event);
      if (place?.above) listener.onDrop(this.#aim(event));
      else if (place) listener.onPick(place.x, place.y);
    });
  }

  /** @param {MouseEvent} event @returns {number | null} metres */
  #aim(event) {
    const place = this.view.aimOf(event);
    return place?.above ? this.listener.aimAt(place.x) : null;
  }

  /** @param {number | null} x metres */
  #hover(x) {
    if (x === this.hover) return;
    this.hover = x;
    this.view.moving.style.cursor = x === null ? "" : "pointer";
    this.listener.onHover();
  }
}
