// One board of the lesson: the balls in the air, and what has landed, by runs.

import { boardOf } from "./board.js";
import { Fall } from "./fall.js";

/** @import { Board } from "../model/board.js" */
/** @import { Solver, Start } from "../solver/solver.js" */
/** @import { Setting } from "./board.js" */
/** @import { Run } from "./lesson.js" */

/**
 * @typedef {{fall: Fall, since: number, seed: string, other: boolean, place: number}} Ball since: ms, when it started;
 *   other: whether a pupil dropped it; place: in the order of dropping
 *
 * @typedef {object} Landed of a run
 * @property {number} seed of its first ball; the others count up
 * @property {number} drops by the teacher, also those still in the air
 * @property {number[]} bins in the order of landing
 * @property {string[]} seeds of these balls
 * @property {number[]} places of these balls in the order of dropping
 * @property {number[]} rights for each row, how many balls went right there
 */

const COMMA = /,/; // a language with decimal commas separates columns by semicolons
const WORK_MS = 8; // of computing, per frame
const SEEDS = 2 ** 32; // a spreadsheet shows them whole

/** A board and its balls. */
export class Trial {
  /** Thrown together, a hair apart; not counted. @type {Ball[]} */
  pair = [];
  /** @type {Ball[]} */
  balls = [];
  /** Whether balls land at once. */
  calm = false;
  #waiting = 0;
  #started = 0;

  /** @param {Solver} solver @param {Setting} setting @param {number} [seed] of the first ball @param {Board} [board] */
  constructor(solver, setting, seed = newSeed(), board = boardOf(setting)) {
    this.solver = solver;
    this.setting = setting;
    this.board = solver.read(board);
    /** @type {Landed[]} */
    this.runs = [];
    this.begin(seed);
  }

  /** Begins a run; balls in the air still count for the last one. @param {number} [seed] */
  begin(seed = newSeed()) {
    for (const ball of this.balls) this.#count(ball);
    this.balls = [];
    this.#waiting = 0;
    const rights = new Array(this.setting.rows).fill(0);
    this.runs.push({ seed, drops: 0, bins: [], seeds: [], places: [], rights });
  }

  /** Removes all runs, and begins the first. @param {number} [seed] */
  clear(seed) {
    this.runs = [];
    this.balls = [];
    this.pair = [];
    this.begin(seed);
  }

  get run() {
    return this.runs[this.runs.length - 1];
  }

  /** What has landed. @param {boolean} all runs, or the current one */
  over(all) {
    const runs = this.#runs(all);
    const counts = new Array(this.setting.rows + 1).fill(0);
    const bins = runs.flatMap((run) => run.bins);
    for (const bin of bins) counts[bin] += 1;
    return { bins, counts, rights: this.run.rights.map((_, row) => runs.reduce((sum, { rights }) => sum + rights[row], 0)) };
  }

  /**
   * A fair sample of what has landed. Quick balls land first, so it has only the balls from before the first one in
   * the air, in the order of dropping.
   * @param {boolean} all runs, or the current one @returns {number[]} their bins
   */
  settled(all) {
    const until = Math.min(...this.balls.map(({ place }) => place));
    return this.#runs(all)
      .flatMap(({ bins, places }) => bins.map((bin, i) => ({ bin, place: places[i] })))
      .filter(({ place }) => place < until).sort((one, two) => one.place - two.place).map(({ bin }) => bin);
  }

  /** @param {boolean} all */
  #runs(all) {
    return all ? this.runs : [this.run];
  }

  /** Lets balls of the next seeds fall. @param {number} balls */
  drop(balls) {
    this.#waiting += balls;
  }

  /** Lets the balls of a link's runs land at once. @param {Run[]} runs */
  restore(runs) {
    runs.forEach(({ seed, drops }, i) => {
      if (i === 0) this.clear(seed);
      else this.begin(seed);
      for (let n = 0; n < drops; n += 1) this.#count(this.#next());
    });
  }

  /**
   * @param {string} seed @param {number | null} x m, if the seed does not give it @param {boolean} other
   * @param {boolean} [landed] whether it fell before
   */
  enter(seed, x, other, landed = false) {
    const ball = this.#start({ seed, x }, other);
    if (landed) this.#count(ball);
    else this.balls.push(ball);
  }

  /** @param {Start} start @param {boolean} other @returns {Ball} */
  #start(start, other) {
    const fall = new Fall(this.solver.drop(this.board, start), this.board);
    return { fall, since: performance.now(), seed: String(start.seed ?? ""), other, place: (this.#started += 1) };
  }

  /** Lets two balls fall that start a hair apart. @param {number} hair m */
  twins(hair) {
    const { x, jitter } = this.board.drop;
    const start = x + jitter * (Math.random() - 0.5);
    const since = performance.now();
    this.pair = [start, start + hair].map((at, i) => ({ ...this.#start({ x: at }, i > 0), since }));
  }

  /** The row at which the pair parts, from 1; null if it never does. @returns {number | null} */
  get parting() {
    const [one, two] = this.pair.map(({ fall }) => fall.turns);
    const row = one?.findIndex((right, i) => right !== two[i]) ?? -1;
    return row < 0 ? null : row + 1;
  }

  /** @param {number} now ms @returns {boolean} whether something moves or is still to be computed */
  advance(now) {
    const start = performance.now();
    while (this.#waiting > 0 && performance.now() - start < WORK_MS) {
      this.#waiting -= 1;
      const ball = this.#next();
      if (this.calm) this.#count(ball);
      else this.balls.push(ball);
    }
    this.balls = this.balls.filter((ball) => {
      const falls = !this.calm && now - ball.since < 1000 * ball.fall.end;
      if (!falls) this.#count(ball);
      return falls;
    });
    const paired = !this.calm && this.pair.some(({ since, fall }) => now - since < 1000 * fall.end);
    return this.#waiting > 0 || this.balls.length > 0 || paired;
  }

  /** @returns {Ball} */
  #next() {
    const seed = String((this.run.seed + this.run.drops) % SEEDS);
    this.run.drops += 1;
    return this.#start({ seed }, false);
  }

  /** @param {Ball} ball */
  #count({ fall, seed, place }) {
    const { run } = this;
    if (fall.bin === null) return; // it came to rest on a peg
    run.bins.push(fall.bin);
    run.seeds.push(seed);
    run.places.push(place);
    fall.turns.forEach((right, row) => {
      run.rights[row] += Number(right);
    });
  }
}

/** @returns {number} */
function newSeed() {
  return crypto.getRandomValues(new Uint32Array(1))[0];
}

/** @param {Trial[]} trials @param {string} language of the spreadsheet @returns {string} all landed balls, a line for each */
export function csvOf(trials, language) {
  const separator = COMMA.test((0.5).toLocaleString(language)) ? ";" : ",";
  const lines = [["board", "run", "ball", "seed", "right", "rows"]];
  trials.forEach(({ runs, setting: { rows } }, board) => runs.forEach(({ bins, seeds }, run) =>
    bins.forEach((bin, ball) => lines.push([board + 1, run + 1, ball + 1, seeds[ball] ?? "", bin, rows].map(String)))));
  return lines.map((line) => `${line.join(separator)}\r\n`).join("");
}
