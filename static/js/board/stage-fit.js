// How large a board may be: as wide as its stage, or as wide as still fits the stage's height.

const STEPS = 24; // of bisection: far below a pixel

/**
 * @param {{width: number, height: number}} room CSS pixels
 * @param {(width: number) => number} heightOf what a picture of that width takes; never falls with it
 * @returns {number} CSS pixels, the widest whole number that fits
 */
export function widest({ width, height }, heightOf) {
  if (heightOf(width) <= height) return Math.floor(width);
  let [fits, breaks] = [0, width];
  for (let step = 0; step < STEPS; step += 1) {
    const middle = (fits + breaks) / 2;
    if (heightOf(middle) <= height) fits = middle;
    else breaks = middle;
  }
  return Math.floor(fits);
}

/** The stage of a board's box; a box that lies on none is as wide as what it lies in. */
export class StageFit {
  /** @param {HTMLElement} box @param {() => void} onResize */
  constructor(box, onResize) {
    this.box = box;
    this.stage = /** @type {HTMLElement | null} */ (box.closest(".stage"));
    new ResizeObserver(onResize).observe(this.stage ?? box);
  }

  /**
   * Makes the box as large as it may be.
   * @param {(width: number) => number} heightOf of the board at a width
   * @returns {number} its width, CSS pixels; 0 while it is not shown
   */
  fit(heightOf) {
    if (!this.stage) return this.box.clientWidth;
    const { clientWidth: width, clientHeight: height } = this.stage;
    if (!width || !height) return 0;
    const fitting = Math.max(1, widest({ width, height }, heightOf));
    this.box.style.width = `${fitting}px`;
    document.documentElement.style.setProperty("--board-width", `${fitting}px`);
    return fitting;
  }

  /**
   * The stage's sunburst goes on where the board's ends.
   * @param {number} height of the board @param {number} dropY its sunburst's middle, CSS pixels
   */
  shine(height, dropY) {
    if (!this.stage) return;
    const top = (this.stage.clientHeight - height) / 2;
    this.stage.style.setProperty("--ray-y", `${Math.round(top + dropY)}px`);
  }
}
