// The balls of an arena as the arrays that the kernels take, in rows by ascending id, and their
// neighbour list. The same operations give the same bits in engine/multibody/bodies.py.

/** @import { Grid, Machine, Value } from "../machine.js" */

const ASLEEP = 1; // bits of a ball's flags
export const LANDED = 4;
export const LEFT = 8;

const STARTS = [0, 5]; // parts of `pairs` with a number for each ball: the pairs', and the held pairs'

/**
 * All values of a ball: m, rad, m/s, rad/s, kg/m².
 * @typedef {Record<"x" | "y" | "theta" | "vx" | "vy" | "omega" | "radius" | "density" | "restitution" |
 *   "friction", number>} BallValues
 */

/** Default values of a ball. */
const USUAL = {
  theta: 0, vx: 0, vy: 0, omega: 0, radius: 0.08, density: 80, restitution: 0.6, friction: 0.2,
};

/** @param {number} n @returns {Grid[]} an empty neighbour list for n balls, as the kernels take it */
export function noPairs(n) {
  const ints = (/** @type {number} */ length) => ({ values: new Int32Array(length), shape: [length] });
  const noImpulses = () => ({ values: new Float64Array(0), shape: [0, 3] });
  return [
    ints(n + 1), ints(0), noImpulses(), ints(n + 1), ints(0), ints(n + 1), ints(0), noImpulses(),
  ];
}

/** Rows of balls; a ball's row changes when balls before it are removed. */
export class BallTable {
  n = 0;
  /** n + 1 rows of x, y, rim arc (angle times radius) and radius; the last stands for pegs and walls. */
  pos = new Float64Array(4);
  /** n + 1 rows of vx, vy, rim speed (spin times radius) and inverse mass. */
  vel = new Float64Array(4);
  /** Rows of restitution and friction. */
  surface = new Float64Array(0);
  /** Rows of the place where a ball's neighbours were listed, and how far from it the list is valid. */
  anchor = new Float64Array(0);
  /** Rows of id, flags, still steps, and the row of the next ball in the island it fell asleep with. */
  marks = new Int32Array(0);
  pairs = noPairs(0);
  /** Whether `pairs` lists the neighbours of the current rows; if not, it only stores impulses. */
  isListed = false;
  #machine;

  /** @param {Machine} machine */
  constructor(machine) {
    this.#machine = machine;
  }

  /** @returns {Value[]} arguments for the kernels */
  get bodies() {
    const { n, pos, vel, surface, anchor, marks } = this;
    return [
      { values: pos, shape: [n + 1, 4] }, { values: vel, shape: [n + 1, 4] },
      { values: surface, shape: [n, 2] }, { values: anchor, shape: [n, 3] },
      { values: marks, shape: [n, 4] },
    ];
  }

  /** @param {number} row @returns {number} */
  id(row) {
    return this.marks[4 * row];
  }

  /** @param {number} row */
  flags(row) {
    return this.marks[4 * row + 1];
  }

  /** @param {number} row */
  isAsleep(row) {
    return (this.flags(row) & ASLEEP) !== 0;
  }

  /** @param {number} row @returns {Pick<BallValues, "radius" | "density" | "restitution" | "friction">} */
  kind(row) {
    const [radius, inverseMass] = [this.pos[4 * row + 3], this.vel[4 * row + 3]];
    const [restitution, friction] = this.surface.subarray(2 * row, 2 * row + 2);
    return { radius, density: 1 / (inverseMass * (Math.PI * radius * radius)), restitution, friction };
  }

  /** @param {number} ball @returns {number} its row, -1 if there is no such ball */
  row(ball) {
    let [low, high] = [0, this.n];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.id(middle) < ball) low = middle + 1;
      else high = middle;
    }
    return low < this.n && this.id(low) === ball ? low : -1;
  }

  /**
   * Adds balls with ids above all others.
   * @param {number} firstId
   * @param {(Partial<BallValues> & {x: number, y: number})[]} balls
   */
  append(firstId, balls) {
    const first = this.n;
    this.#resize(first + balls.length);
    balls.forEach((given, i) => {
      const row = first + i;
      const ball = { ...USUAL, ...given };
      const { radius } = ball;
      this.pos.set([ball.x, ball.y, ball.theta * radius, radius], 4 * row);
      const mass = ball.density * (Math.PI * radius * radius);
      this.vel.set([ball.vx, ball.vy, ball.omega * radius, 1 / mass], 4 * row);
      this.surface.set([ball.restitution, ball.friction], 2 * row);
      this.marks.set([firstId + i, 0, 0, row], 4 * row);
    });
    this.pairs = this.pairs.map((part, i) => (STARTS.includes(i) ? this.#continued(part, first) : part));
    this.isListed = false;
  }

  /**
   * Starts of pairs, continued for balls without any.
   * @param {Grid} starts @param {number} first row of the new balls
   * @returns {Grid}
   */
  #continued(starts, first) {
    const longer = new Int32Array(this.n + 1).fill(Number(starts.values[first]));
    longer.set(/** @type {Int32Array} */ (starts.values));
    return { values: longer, shape: [longer.length] };
  }

  /** @param {number} n the new number of rows; the first ones are kept, others are zero */
  #resize(n) {
    const kept = Math.min(this.n, n);
    this.n = n;
    this.pos = resized(this.pos, 4 * kept, 4 * (n + 1));
    this.vel = resized(this.vel, 4 * kept, 4 * (n + 1));
    this.surface = resized(this.surface, 2 * kept, 2 * n);
    this.anchor = resized(this.anchor, 3 * kept, 3 * n);
    this.marks = resized(this.marks, 4 * kept, 4 * n);
  }

  /**
   * Removes all other rows, and keeps the impulses between these. Sleeping islands must be kept or
   * removed as a whole.
   * @param {number[]} rows ascending
   */
  keep(rows) {
    const target = new Int32Array(this.n).fill(-1);
    rows.forEach((row, i) => {
      target[row] = i;
    });
    const n = rows.length;
    for (const [array, width] of /** @type {[Float64Array | Int32Array, number][]} */ ([
      [this.pos, 4], [this.vel, 4], [this.surface, 2], [this.anchor, 3], [this.marks, 4],
    ])) {
      rows.forEach((row, i) => array.copyWithin(width * i, width * row, width * (row + 1)));
    }
    this.#resize(n);
    for (let row = 0; row < n; row += 1) this.marks[4 * row + 3] = target[this.marks[4 * row + 3]];
    this.pairs = this.#machine.run("plinko.engine.multibody.solver.neighbour_list.select_pairs", [
      ...this.pairs, { values: target, shape: [target.length] }, n,
    ]);
    this.isListed = false;
  }

  /** Wakes the ball of a row and its island. @param {number} row */
  wakeWith(row) {
    const { marks } = this;
    while (this.isAsleep(row)) {
      const next = marks[4 * row + 3];
      marks[4 * row + 1] &= ~ASLEEP;
      marks[4 * row + 2] = 0;
      marks[4 * row + 3] = row;
      this.isListed = false;
      row = next;
    }
  }

  wakeAll() {
    for (let row = 0; row < this.n; row += 1) {
      if (this.isAsleep(row)) this.isListed = false;
      this.marks[4 * row + 1] &= ~ASLEEP;
      this.marks[4 * row + 2] = 0;
      this.marks[4 * row + 3] = row;
    }
  }

  /**
   * Sets values of these rows. With a new radius a ball keeps its density, its angle and its spin.
   * @param {number[]} rows
   * @param {Partial<Pick<BallValues, "radius" | "density" | "restitution" | "friction">>} values
   */
  edit(rows, { radius, density, restitution, friction }) {
    for (const row of rows) this.wakeWith(row);
    for (const row of rows) {
      if (radius !== undefined) {
        const ratio = radius / this.pos[4 * row + 3];
        this.pos[4 * row + 2] *= ratio;
        this.vel[4 * row + 2] *= ratio;
        this.vel[4 * row + 3] /= ratio * ratio;
        this.pos[4 * row + 3] = radius;
      }
      const size = this.pos[4 * row + 3];
      if (density !== undefined) this.vel[4 * row + 3] = 1 / (density * (Math.PI * size * size));
      if (restitution !== undefined) this.surface[2 * row] = restitution;
      if (friction !== undefined) this.surface[2 * row + 1] = friction;
    }
    this.isListed = false;
  }

  /** Adds to a velocity. @param {number} row @param {number} dvx @param {number} dvy @param {number} domega */
  kick(row, dvx, dvy, domega) {
    this.wakeWith(row);
    this.vel[4 * row] += dvx;
    this.vel[4 * row + 1] += dvy;
    this.vel[4 * row + 2] += domega * this.pos[4 * row + 3];
  }
}

/**
 * @template {Float64Array | Int32Array} T
 * @param {T} array @param {number} kept numbers that are copied @param {number} length
 * @returns {T}
 */
function resized(array, kept, length) {
  const made = new (/** @type {new (length: number) => T} */ (array.constructor))(length);
  made.set(array.subarray(0, kept));
  return made;
}
