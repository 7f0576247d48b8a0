// Draws at the display's rate, only while something moves.

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
