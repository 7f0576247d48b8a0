// When the next of many drops is due: at a steady rate, never several at once to catch up. Pure.

/** A number of drops, evenly spaced; the caller brings the time. */
export class Pacer {
  left;
  #next;

  /**
   * @param {number} rate a second
   * @param {number} count how many in all; Infinity for no end
   * @param {number} nowMs the first is due at once
   */
  constructor(rate, count, nowMs) {
    this.spacing = 1000 / rate;
    this.left = count;
    this.#next = nowMs;
  }

  get done() {
    return this.left <= 0;
  }

  /** @param {number} nowMs @returns {number} ms until the next is due */
  wait(nowMs) {
    return Math.max(0, this.#next - nowMs);
  }

  /**
   * @param {number} nowMs
   * @returns {boolean} true when one is due: it counts as given from then on
   */
  take(nowMs) {
    if (this.done || nowMs < this.#next) return false;
    this.left -= 1;
    // After a pause (a hidden tab's timers sleep) what was missed is not made up for.
    this.#next = Math.max(this.#next + this.spacing, nowMs + 0.5 * this.spacing);
    return true;
  }

  /** None could be given: the same one is due again a little later. @param {number} nowMs */
  postpone(nowMs) {
    this.left += 1;
    this.#next = nowMs + this.spacing;
  }
}
