// The colours of the balls in each bin, in the order of their landings. Pure.

export class Colours {
  /** @type {(string | null)[][]} by bin; null for balls that landed before the page was opened */
  #bins = [];

  /** @param {number[]} counts all landings, by bin; a new run of the room begins again with fewer */
  fit(counts) {
    const goesOn = counts.length === this.#bins.length && this.#bins.every(({ length }, bin) => length <= counts[bin]);
    const known = goesOn ? this.#bins : counts.map(() => []);
    this.#bins = counts.map((count, bin) => [...known[bin], ...Array(count - known[bin].length).fill(null)]);
  }

  /** @param {number} bin @param {string | null} colour */
  add(bin, colour) {
    this.#bins[bin].push(colour);
  }

  /** @param {number} bin @param {number} ball in order of landing, from 0 @returns {string | null} */
  of(bin, ball) {
    return this.#bins[bin][ball] ?? null;
  }

  /** @param {number} bin @returns {{colour: string | null, balls: number}[]} in the order of the first landings */
  sharesOf(bin) {
    /** @type {Map<string | null, number>} */
    const balls = new Map();
    for (const colour of this.#bins[bin]) balls.set(colour, (balls.get(colour) ?? 0) + 1);
    return [...balls].map(([colour, count]) => ({ colour, balls: count }));
  }
}
