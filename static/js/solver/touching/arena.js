// Balls that touch each other, advanced by the engine's kernels. It corresponds to
// engine/multibody/arena.py: the same inputs at the same steps give the same bits.

import { BallTable, LANDED, LEFT, noPairs } from "./ball-table.js";
import { staticShapes } from "./static-shapes.js";

/** @import { Grid, Machine, Value } from "../machine.js" */
/** @import { BallValues } from "./ball-table.js" */
/** @import { Place } from "./scenes.js" */

const MODULE = "plinko.engine.multibody.solver.";
const SLEEP_SECONDS = 0.5; // an island that has been still for this long falls asleep
const ROOM_PER_BALL = 4; // impacts that a step's log has room for
const COUNTS = 4;
const [LANDINGS, DEPARTURES, AWAKE_BEFORE] = [1, 2, 3]; // of counts

/**
 * gravity: m/s², downward; drag: 1/s; damping: the fraction of the velocity kept in a step; correction:
 * the fraction of an overlap corrected in a substep; dt: of a step, s.
 * @typedef {{gravity: number, drag: number, damping: number, correction: number, dt: number,
 *   substeps: number}} ArenaSettings
 */

/** @typedef {{contacts: number, penetration: number}} Overlap penetration: the deepest, m */

/** Balls among fixed pegs and walls. */
export class Arena {
  /** Sum of all steps, s. */
  time = 0;
  table;
  #nextId = 0;
  #accumulator = 0;
  #rests = false;

  /** @param {Machine} machine @param {Place} place @param {ArenaSettings} settings */
  constructor(machine, place, settings) {
    this.machine = machine;
    this.place = place;
    this.settings = { ...settings };
    this.table = new BallTable(machine);
    this.statics = staticShapes(machine, place);
  }

  get count() {
    return this.table.n;
  }

  /** Whether anything moves; if not, a step changes only the time. */
  get awake() {
    for (let row = 0; row < this.count; row += 1) if (!this.table.isAsleep(row)) return true;
    return false;
  }

  /**
   * @param {(Partial<BallValues> & {x: number, y: number})[]} balls
   * @returns {number} the id of the first ball; the others are numbered on from it
   */
  add(balls) {
    const first = this.#nextId;
    this.table.append(first, balls);
    this.#nextId += balls.length;
    return first;
  }

  /** Removes a ball. @param {number} ball must exist */
  remove(ball) {
    const row = this.table.row(ball);
    this.table.wakeWith(row);
    this.#drop([row]);
  }

  clear() {
    this.table.wakeAll();
    this.table.keep([]);
  }

  /** @param {number[]} rows */
  #drop(rows) {
    const gone = new Set(rows);
    this.table.keep(Array.from({ length: this.count }, (_, row) => row).filter((row) => !gone.has(row)));
  }

  /** Changes settings and wakes all balls. @param {Partial<ArenaSettings>} values */
  configure(values) {
    Object.assign(this.settings, values);
    this.table.wakeAll();
  }

  /** Advances by one step. @returns {number[]} balls that landed or went too far, and were removed */
  step() {
    const { table } = this;
    this.time += this.settings.dt;
    if (table.n === 0 || (this.#rests && table.isListed)) return [];
    const counts = new BigInt64Array(COUNTS);
    table.pairs = this.machine.run(`${MODULE}step.step_balls`, [
      ...table.bodies, table.n, ...table.pairs, ...this.statics, ...this.#solverSettings(),
      ...newLog(table.n, counts), table.isListed,
    ]);
    this.#rests = counts[AWAKE_BEFORE] === 0n;
    if (this.#rests) return [];
    table.isListed = true;
    return counts[LANDINGS] || counts[DEPARTURES] ? this.#takeGone() : [];
  }

  #takeGone() {
    const { table } = this;
    const rows = Array.from({ length: table.n }, (_, row) => row)
      .filter((row) => table.flags(row) & (LANDED | LEFT));
    const balls = rows.map((row) => table.id(row));
    this.#drop(rows);
    return balls;
  }

  /** Advances in whole steps. @param {number} seconds @returns {number[]} balls that were removed */
  advance(seconds) {
    const gone = [];
    this.#accumulator += seconds;
    while (this.#accumulator >= this.settings.dt) {
      this.#accumulator -= this.settings.dt;
      gone.push(...this.step());
    }
    return gone;
  }

  /** The deepest overlap and the number of contacts, also of sleeping balls. */
  overlap() {
    const { table } = this;
    if (table.n === 0) return { contacts: 0, penetration: 0 };
    const bodies = table.bodies.map(copied);
    const [, vel, , , marks] = /** @type {Grid<Float64Array | Int32Array>[]} */ (bodies);
    vel.values.fill(0);
    for (let row = 0; row < table.n; row += 1) marks.values[4 * row + 1] = table.flags(row) & ~1;
    const pairs = this.machine.run(`${MODULE}neighbour_list.rebuild`, [
      ...bodies, table.n, ...this.statics, ...noPairs(table.n), 0, 0,
    ]).slice(0, -1);
    const [penetration, , contacts] = this.machine.run(
      `${MODULE}position_projection.deepest_overlap`, [...bodies, table.n, ...pairs, ...this.statics],
    );
    return { contacts, penetration };
  }

  /** @returns {Value[]} arguments for the kernels */
  #solverSettings() {
    const { gravity, drag, damping, correction, dt, substeps } = this.settings;
    const stillSteps = Math.max(2, roundHalfEven(SLEEP_SECONDS / dt));
    return [gravity, drag, damping, correction, dt / substeps, substeps, Infinity,
      stillSteps];
  }
}

/** @param {number} balls @param {BigInt64Array} counts @returns {Value[]} an empty log for a step of that many balls */
function newLog(balls, counts) {
  const rows = ROOM_PER_BALL * balls + 16;
  return [
    { values: new Float64Array(4 * rows), shape: [rows, 4] },
    { values: new Int32Array(2 * rows), shape: [rows, 2] },
    { values: new Float64Array(2 * (balls + 1)), shape: [balls + 1, 2] },
    { values: new Int32Array(balls + 1), shape: [balls + 1] },
    { values: counts, shape: [COUNTS] },
  ];
}

/** @param {Value} value @returns {Value} */
function copied(value) {
  return typeof value === "object" && "values" in value
    ? { ...value, values: value.values.slice() } : value;
}

/** Rounds like Python. @param {number} value @returns {number} */
function roundHalfEven(value) {
  const down = Math.floor(value);
  const over = value - down;
  if (over !== 0.5) return Math.round(value);
  return down % 2 === 0 ? down : down + 1;
}
