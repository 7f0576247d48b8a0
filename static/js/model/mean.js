// A running mean. Pure.

/** Running mean and sum of squared deviations, by Welford's method: the values are not stored. */
export class Mean {
  /** @param {{count?: number, mean?: number, square?: number}} [saved] */
  constructor({ count = 0, mean = 0, square = 0 } = {}) {
    this.count = count;
    this.mean = mean;
    this.square = square;
  }

  /** @param {number} value @param {number} [times] */
  add(value, times = 1) {
    if (times === 0) return;
    this.count += times;
    const step = value - this.mean;
    this.mean += (step * times) / this.count;
    this.square += times * step * (value - this.mean);
  }
}
