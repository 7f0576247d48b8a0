// Measurements over time in bounded memory: when it is full, every second one is removed. Pure.

const ROWS = 720;

/** Columns of numbers; the first is the time. */
export class Series {
  count = 0;
  #skip = 1; // one in this many rows is kept
  #turn = 0;

  /** @param {string[]} names of the columns @param {number} [most] rows kept */
  constructor(names, most = ROWS) {
    this.names = names;
    this.most = most;
    this.columns = Object.fromEntries(names.map((name) => [name, new Float64Array(most)]));
  }

  /** @param {Record<string, number>} row */
  add(row) {
    this.#turn += 1;
    if (this.#turn % this.#skip !== 0) return;
    if (this.count === this.most) this.#thin();
    for (const name of this.names) this.columns[name][this.count] = row[name];
    this.count += 1;
  }

  clear() {
    this.count = 0;
    this.#skip = 1;
    this.#turn = 0;
  }

  /** @returns {Record<string, number>[]} in the order in which they were added */
  get rows() {
    return Array.from({ length: this.count }, (_, i) => Object.fromEntries(this.names.map((name) => [name, this.columns[name][i]])));
  }

  #thin() {
    const half = Math.floor(this.most / 2);
    for (const column of Object.values(this.columns)) {
      for (let i = 0; i < half; i += 1) column[i] = column[2 * i];
    }
    this.count = half;
    this.#skip *= 2;
  }
}
