// The rectangles of a canvas that must be cleared before the next frame. Pure except for `clear`.

const MOST = 1024; // rectangles; with more the whole canvas is cleared
const SHARE = 0.6; // of the canvas; above it, clearing everything at once is cheaper

/** Rectangles in CSS pixels, in one array that is reused. */
export class Damage {
  #boxes = new Float64Array(4 * MOST);
  #count = 0;
  #area = 0;

  /** @param {number} x @param {number} y @param {number} width @param {number} height */
  add(x, y, width, height) {
    this.#area += width * height;
    if (this.#count === MOST) {
      this.#area = Number.POSITIVE_INFINITY;
      return;
    }
    const at = 4 * this.#count;
    this.#boxes[at] = x;
    this.#boxes[at + 1] = y;
    this.#boxes[at + 2] = width;
    this.#boxes[at + 3] = height;
    this.#count += 1;
  }

  /** @param {Float64Array} points x0 y0 x1 y1 … @param {number} count @param {number} margin */
  addPoints(points, count, margin) {
    if (count === 0) return;
    let left = points[0];
    let right = left;
    let top = points[1];
    let bottom = top;
    for (let i = 1; i < count; i += 1) {
      left = Math.min(left, points[2 * i]);
      right = Math.max(right, points[2 * i]);
      top = Math.min(top, points[2 * i + 1]);
      bottom = Math.max(bottom, points[2 * i + 1]);
    }
    const width = right - left + 2 * margin;
    this.add(left - margin, top - margin, width, bottom - top + 2 * margin);
  }

  /**
   * Clears the rectangles and forgets them.
   * @param {CanvasRenderingContext2D} ctx
   * @param {number} width
   * @param {number} height
   */
  clear(ctx, width, height) {
    if (this.#area > SHARE * width * height) {
      ctx.clearRect(0, 0, width, height);
    } else {
      const boxes = this.#boxes;
      for (let at = 0; at < 4 * this.#count; at += 4) {
        ctx.clearRect(boxes[at], boxes[at + 1], boxes[at + 2], boxes[at + 3]);
      }
    }
    this.#count = 0;
    this.#area = 0;
  }
}
