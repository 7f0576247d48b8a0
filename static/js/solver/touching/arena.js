// Balls that touch each other, advanced by the engine's kernels. It corresponds to
// engine/multibody/arena.py: the same inputs at the same steps give the same bits.

import { floats } from "../machine.js";
import { BallTable, LANDED, LEFT, noPairs } from "./ball-table.js";

/** @import { Grid, Machine, Value } from "../machine.js" */
/** @import { BallValues } from "./ball-table.js" */
/** @import { Place } from "./scenes.js" */

const MODULE = "plinko.engine.multibody.solver.";
const SLEEP_SECONDS = 0.5; // an island that has been still for this long falls asleep
const ROOM_PER_BALL = 4; // impacts that a step's log has room for
const COUNTS = 4;
const [LANDINGS, DEPARTURES, AWAKE_BEFORE] = [1, 2, 3]; // of counts

/**
 * gravity, gravity_x: m/s², downward and to the right; drag: 1/s; damping: the fraction of the velocity
 * kept in a step; rolling: the coefficient of rolling resistance; max_speed: m/s, 0 for no limit;
 * correction: the fraction of an overlap corrected in a substep; projection: 1 if the end of a step removes
 * what is left of it, or 0; dt: of a step, s; cell: of the broad phase, m, 0 to choose it by the balls' sizes.
 * @typedef {Record<"gravity" | "gravity_x" | "drag" | "damping" | "rolling" | "max_speed" | "correction" |
 *   "projection" | "dt" | "substeps" | "cell", number>} ArenaSettings
 */

/** The settings' names. @type {(keyof ArenaSettings)[]} */
export const SETTINGS = ["gravity", "gravity_x", "drag", "damping", "rolling", "max_speed", "correction",
  "projection", "dt", "substeps", "cell"];

/** @typedef {[number, number, number, number]} Corners x_min, x_max, y_min, y_max in m */

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

  /** Sets the friction of all pegs and walls. @param {number} friction */
  editPlace(friction) {
    const { peg_material: ofPegs, wall_material: ofWalls } = this.place;
    this.place = {
      ...this.place, peg_material: { ...ofPegs, friction }, wall_material: { ...ofWalls, friction },
    };
    this.statics = staticShapes(this.machine, this.place);
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

  /** The deepest overlap, m, and the number of contacts, also of sleeping balls. */
  overlap() {
    const { table } = this;
    if (table.n === 0) return { contacts: 0, penetration: 0 };
    const bodies = table.bodies.map(copied);
    const [, vel, , , marks] = /** @type {Grid<Float64Array | Int32Array>[]} */ (bodies);
    vel.values.fill(0);
    for (let row = 0; row < table.n; row += 1) marks.values[4 * row + 1] = table.flags(row) & ~1;
    const pairs = this.machine.run(`${MODULE}neighbour_list.rebuild`, [
      ...bodies, table.n, ...this.statics, ...noPairs(table.n), ...this.#solverSettings(),
    ]).slice(0, -1);
    const [penetration, , contacts] = this.machine.run(
      `${MODULE}position_projection.deepest_overlap`, [...bodies, table.n, ...pairs, ...this.statics],
    );
    return { contacts, penetration };
  }

  /** @returns {Corners} of the box around pegs, walls and bins */
  get extent() {
    return extentOf(this.place);
  }

  /** Energies in J (potential: zero at the origin), momenta in kg m/s and kg m²/s, penetration and cell in m. */
  diagnostics() {
    const { table, settings } = this;
    const sum = { kinetic: 0, potential: 0, rotational: 0, px: 0, py: 0, angular: 0, asleep: 0 };
    for (let row = 0; row < table.n; row += 1) {
      const [x, y, , radius] = table.pos.subarray(4 * row, 4 * row + 4);
      const [vx, vy, rimSpeed, inverseMass] = table.vel.subarray(4 * row, 4 * row + 4);
      const mass = 1 / inverseMass;
      sum.kinetic += 0.5 * mass * (vx * vx + vy * vy);
      sum.potential -= mass * (settings.gravity_x * x + settings.gravity * y);
      sum.rotational += 0.25 * mass * rimSpeed * rimSpeed;
      sum.px += mass * vx;
      sum.py += mass * vy;
      sum.angular += mass * (x * vy - y * vx + 0.5 * radius * rimSpeed);
      if (table.isAsleep(row)) sum.asleep += 1;
    }
    const total = sum.kinetic + sum.potential + sum.rotational;
    const cell = table.n === 0 ? 0
      : this.machine.run(`${MODULE}broad_phase.smallest_cell`, [...table.bodies, table.n, settings.cell])[0];
    return { ...sum, total, ...this.overlap(), count: table.n, time: this.time, cell };
  }

  /** @returns {Value[]} arguments for the kernels */
  #solverSettings() {
    const { gravity, gravity_x: across, drag, damping, rolling, max_speed: most, correction, projection, dt,
      substeps, cell } = this.settings;
    const stillSteps = Math.max(2, roundHalfEven(SLEEP_SECONDS / dt));
    const least = false; // a pair has the greater restitution of its two
    return [across, gravity, Math.sqrt(across * across + gravity * gravity), drag, damping, correction,
      dt / substeps, substeps, most || Infinity, stillSteps, rolling, least, projection !== 0, cell];
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

/** @param {Place} place @returns {Corners} of the box around all parts */
function extentOf({ pegs, walls, bins }) {
  const xs = walls.flatMap(({ x1, x2 }) => [x1, x2]);
  const ys = walls.flatMap(({ y1, y2 }) => [y1, y2]);
  for (const { x, y, radius } of pegs) {
    xs.push(x - radius, x + radius);
    ys.push(y - radius, y + radius);
  }
  if (bins) {
    xs.push(bins.edges[0], /** @type {number} */ (bins.edges.at(-1)));
    ys.push(bins.y);
  }
  const least = (/** @type {number[]} */ values) => values.reduce((one, other) => Math.min(one, other));
  const most = (/** @type {number[]} */ values) => values.reduce((one, other) => Math.max(one, other));
  return xs.length ? [least(xs), most(xs), least(ys), most(ys)] : [0, 0, 0, 0];
}

/**
 * The pegs and walls as the kernels take them, with the grid that finds them.
 * @param {Machine} machine @param {Place} place
 * @returns {Value[]} arguments for the kernels
 */
function staticShapes(machine, place) {
  const { pegs, walls, peg_material: ofPegs, wall_material: ofWalls, bins } = place;
  return machine.run("plinko.engine.multibody.solver.static_grid.lay_out_shapes", [
    floats(pegs.flatMap(({ x, y, radius }) => [x, y, radius]), pegs.length, 3),
    floats(walls.flatMap(({ x1, y1, x2, y2 }) => [x1, y1, x2, y2]), walls.length, 4),
    ofPegs.restitution, ofPegs.friction, ofWalls.restitution, ofWalls.friction, ...extentOf(place),
    bins?.y ?? Infinity,
  ]);
}
