// Measurements against time in bounded memory: when it is full, every second one goes. Pure.

const ROWS = 720;

/** Columns of numbers, the first of them the time. */
export class Series {
  count = 0;
  #skip = 1; // one of so many is kept
  #turn = 0;

  /** @param {string[]} names of the columns @param {number} [rows] most that are kept */
  constructor(names, rows = ROWS) {
    this.names = names;
    this.rows = rows;
    this.columns = Object.fromEntries(names.map((name) => [name, new Float64Array(rows)]));
  }

  /** @param {Record<string, number>} row */
  add(row) {
    this.#turn += 1;
    if (this.#turn % this.#skip !== 0) return;
    if (this.count === this.rows) this.#thin();
    for (const name of this.names) this.columns[name][this.count] = row[name];
    this.count += 1;
  }

  clear() {
    this.count = 0;
    this.#skip = 1;
    this.#turn = 0;
  }

  /** @param {string} x @param {string} y names of columns @returns {{x: number, y: number}[]} */
  points(x, y) {
    const [across, up] = [this.columns[x], this.columns[y]];
    return Array.from({ length: this.count }, (_, i) => ({ x: across[i], y: up[i] }));
  }

  /** @param {string} name @returns {number} the newest of a column; NaN of none */
  last(name) {
    return this.count ? this.columns[name][this.count - 1] : Number.NaN;
  }

  #thin() {
    const half = Math.floor(this.rows / 2);
    for (const column of Object.values(this.columns)) {
      for (let i = 0; i < half; i += 1) column[i] = column[2 * i];
    }
    this.count = half;
    this.#skip *= 2;
  }
}
