// Divides work: drawing at the display's rate, only while something moves, and long work in parts.

/** Lets the browser paint and react before the next part of long work. @returns {Promise<void>} */
export const pause = () => new Promise((done) => { window.setTimeout(done); });

/** @returns {Promise<number>} settles in the next frame, before it is painted */
export const nextFrame = () => new Promise((done) => { requestAnimationFrame(done); });

/** Calls `draw(nowMs)` each frame until it returns false; `wake()` starts it again. */
export class FrameLoop {
  #frame = 0;

  /** @param {(nowMs: number) => boolean} draw returns whether to draw another frame */
  constructor(draw) {
    this.draw = draw;
  }

  wake() {
    if (this.#frame === 0) this.#frame = requestAnimationFrame((now) => this.#run(now));
  }

  /** @param {number} now */
  #run(now) {
    this.#frame = 0;
    if (this.draw(now)) this.wake();
  }
}
