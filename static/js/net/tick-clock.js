// Computes which tick to draw now, from the ticks in the server's messages, despite jitter, drift and sleep.

const WINDOW = 120; // samples, and
const WINDOW_MS = 2000; // of at most this age, so that the estimate follows drift
const MIN_BUFFER_TICKS = 3;
const MAX_BUFFER_TICKS = 15; // a quarter of a second; a longer delay is worse than a rough picture
const SLEW = 0.1; // a correction changes the speed of the picture by at most this fraction
const JUMP_SECONDS = 0.4; // a larger error (hidden tab, sleeping room) is corrected at once

/**
 * Estimates the local time at which each tick happened.
 *
 * Each message gives one sample: local time of arrival minus time of its tick. The smallest sample of
 * the window belongs to the fastest delivery and is used as the offset. The spread above it is the
 * jitter, which the delay of the picture must cover.
 */
export class TickClock {
  /** Offset: local time of arrival minus time of the tick. @type {{at: number, offset: number}[]} */
  #samples = [];
  #shown = Number.NaN;
  #shownAt = 0;

  /** @param {{rate: number}} options ticks per second */
  constructor({ rate }) {
    this.rate = rate;
  }

  /** Forgets the offset, which changes when a room sleeps. */
  restart() {
    this.#samples = [];
  }

  /** @param {number} tick of a message @param {number} nowMs local time of its arrival */
  observe(tick, nowMs) {
    this.#samples.push({ at: nowMs, offset: nowMs - (tick * 1000) / this.rate });
    if (this.#samples.length > WINDOW) this.#samples.shift();
  }

  /** How far the picture is behind the fastest delivery, in ticks. */
  get delayTicks() {
    const { least, most } = this.#range();
    const jitterTicks = ((most - least) * this.rate) / 1000;
    return Math.min(MAX_BUFFER_TICKS, Math.max(MIN_BUFFER_TICKS, jitterTicks + 1));
  }

  /**
   * The (fractional) tick to draw at a local time. It never decreases, except in a jump.
   * @param {number} nowMs
   */
  renderTick(nowMs) {
    const elapsed = ((nowMs - this.#shownAt) * this.rate) / 1000;
    this.#shownAt = nowMs;
    if (this.#samples.length === 0) {
      if (Number.isNaN(this.#shown)) return 0;
      this.#shown += elapsed;
      return this.#shown;
    }
    const ideal = ((nowMs - this.#range().least) * this.rate) / 1000 - this.delayTicks;
    const error = ideal - (this.#shown + elapsed);
    if (!(Math.abs(error) <= JUMP_SECONDS * this.rate)) {
      this.#shown = ideal;
    } else {
      const most = SLEW * elapsed;
      this.#shown += elapsed + Math.max(-most, Math.min(most, error));
    }
    return this.#shown;
  }

  #range() {
    const since = (this.#samples.at(-1)?.at ?? 0) - WINDOW_MS;
    const offsets = this.#samples.filter(({ at }) => at >= since).map(({ offset }) => offset);
    return { least: Math.min(...offsets), most: Math.max(...offsets) };
  }
}
