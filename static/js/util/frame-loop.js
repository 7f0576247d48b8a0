// Divides work: drawing at the display's rate, only while something moves, and long work in parts.

const SOON_MS = 200;

/**
 * Lets the browser paint and react before the next part of long work.
 * @param {number} [ms] @returns {Promise<void>}
 */
export const pause = (ms = 0) => new Promise((done) => { window.setTimeout(done, ms); });

/** @returns {Promise<number>} settles in the next frame, before it is painted */
export const nextFrame = () => new Promise((done) => { requestAnimationFrame(done); });

/** Lets the browser paint what it has of the page, before long work. A page out of sight gets no frames. */
export const painted = () => Promise.race([nextFrame().then(nextFrame), pause(SOON_MS)]);

/** Calls `draw(nowMs)` each frame until it returns false; `wake()` starts it again. */
export class FrameLoop {
  #frame = 0;

  /** @param {(nowMs: number) => boolean} draw returns whether to draw another frame */
  constructor(draw) {
    this.draw = draw;
  }

  wake() {
    if (this.#frame !== 0) return;
    this.#frame = requestAnimationFrame((now) => {
      this.#frame = 0;
      if (this.draw(now)) this.wake();
    });
  }
}
