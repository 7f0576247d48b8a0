// Which tick to draw now: follows the server's tick stamps through jitter, drift and sleep.

const WINDOW = 120; // samples, and
const WINDOW_MS = 2000; // of what time at most: short enough to follow drift
const MAX_BUFFER_TICKS = 15; // a quarter second; beyond it a late picture is worse than a rough one
const SLEW = 0.1; // the picture runs at 0.9 to 1.1 of true speed while it corrects itself
const JUMP_SECONDS = 0.4; // further off than this (hidden tab, slept room) it is set, not slewed

/**
 * Keeps a continuous estimate of the local time at which each tick happened.
 *
 * Each stamp gives one sample: local time of arrival minus tick time. The least sample of the
 * window is the quickest delivery, so it is the offset; the spread above it is the jitter that
 * the buffer has to cover.
 */
export class TickClock {
  #samples = new Float64Array(WINDOW);
  #arrivals = new Float64Array(WINDOW);
  #count = 0;
  #shown = Number.NaN;
  #shownAt = 0;

  /** @param {{rate: number, bufferTicks?: number}} options rate in ticks per second */
  constructor({ rate, bufferTicks = 3 }) {
    this.rate = rate;
    this.bufferTicks = bufferTicks;
  }

  /** Forgets the offset: a room that slept wakes with another one. */
  restart() {
    this.#count = 0;
  }

  /** @param {number} tick stamp of a message @param {number} nowMs local time of its arrival */
  observe(tick, nowMs) {
    this.#samples[this.#count % WINDOW] = nowMs - (tick * 1000) / this.rate;
    this.#arrivals[this.#count % WINDOW] = nowMs;
    this.#count += 1;
  }

  /** How far the picture is held behind the quickest stamps, in ticks. */
  get delayTicks() {
    const { least, most } = this.#range();
    const jitterTicks = ((most - least) * this.rate) / 1000;
    return Math.min(MAX_BUFFER_TICKS, Math.max(this.bufferTicks, jitterTicks + 1));
  }

  /**
   * The (fractional) tick to draw at a local time. Never runs backwards except when it jumps.
   * @param {number} nowMs
   */
  renderTick(nowMs) {
    if (this.#count === 0) return Number.isNaN(this.#shown) ? 0 : this.#coast(nowMs);
    const ideal = ((nowMs - this.#range().least) * this.rate) / 1000 - this.delayTicks;
    const elapsed = ((nowMs - this.#shownAt) * this.rate) / 1000;
    const error = ideal - (this.#shown + elapsed);
    if (!(Math.abs(error) <= JUMP_SECONDS * this.rate)) {
      this.#shown = ideal;
    } else {
      const most = SLEW * elapsed;
      this.#shown += elapsed + Math.max(-most, Math.min(most, error));
    }
    this.#shownAt = nowMs;
    return this.#shown;
  }

  /** @param {number} nowMs */
  #coast(nowMs) {
    this.#shown += ((nowMs - this.#shownAt) * this.rate) / 1000;
    this.#shownAt = nowMs;
    return this.#shown;
  }

  #range() {
    const kept = Math.min(this.#count, WINDOW);
    const since = this.#arrivals[(this.#count - 1) % WINDOW] - WINDOW_MS;
    let least = Number.POSITIVE_INFINITY;
    let most = Number.NEGATIVE_INFINITY;
    for (let i = 0; i < kept; i += 1) {
      if (this.#arrivals[i] < since) continue;
      least = Math.min(least, this.#samples[i]);
      most = Math.max(most, this.#samples[i]);
    }
    return { least, most };
  }
}
