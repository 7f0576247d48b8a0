// Moves the discs of a pile by the engine's kernels for touching balls.

import { Arena } from "../../solver/touching/arena.js";
import { loadMachine } from "../../solver/touching/machine.js";
import { SOLVER } from "../../solver/touching/values.js";
import { fittedEntry, placeOf } from "./columns.js";

/** @import { Machine } from "../../solver/machine.js" */
/** @import { Entry, Plan } from "./columns.js" */

/** @typedef {{bin: number, number: number, x: number, y: number, angle: number}} Disc number: in its column; m and rad */

const DISC = { density: 80, restitution: 0.3, friction: 0.3 };
const CLEAR = 2.1; // radii between the centres of an entering disc and the one before it

/** @returns {Promise<{heapFor: (plan: Plan) => Heap, stepMs: number}>} throws without WebAssembly */
export async function openHeaps() {
  const machine = await loadMachine();
  return { heapFor: (plan) => new Heap(machine, plan), stepMs: 1000 * SOLVER.dt };
}

/** Discs that fall into columns, pile up and come to rest. */
export class Heap {
  /** Column of each disc and its number there, by id. @type {{bin: number, number: number}[]} */
  #discs = [];
  /** Discs that have entered, by column. @type {number[]} */
  #entered;
  /** Discs that have not entered yet, by column. @type {Entry[][]} */
  #waiting;
  /** Whether a disc cannot enter, although all discs are at rest. */
  full = false;
  /** The places before the last step. @type {Disc[]} */
  #before = [];

  /** @param {Machine} machine @param {Plan} plan */
  constructor(machine, plan) {
    this.plan = plan;
    this.#waiting = plan.room.map(() => []);
    this.#entered = plan.room.map(() => 0);
    this.arena = new Arena(machine, placeOf(plan), { ...SOLVER, gravity: plan.gravity, drag: 0 });
  }

  /** Adds a disc, which enters as soon as its column has room. @param {number} bin @param {Entry} entry */
  add(bin, entry) {
    this.#waiting[bin].push(fittedEntry(this.plan, bin, entry));
  }

  get #waits() {
    return this.#waiting.some((entries) => entries.length);
  }

  /** Whether the next step changes anything. */
  get runs() {
    return this.arena.awake || (this.#waits && !this.full);
  }

  step() {
    const entered = this.#letIn();
    this.#before = this.#places();
    // If a disc has left the arena, the rows have changed.
    if (this.arena.step().length) this.#before = this.#places();
    this.full = this.#waits && !entered && !this.arena.awake;
  }

  /** @returns {boolean} whether a disc has entered */
  #letIn() {
    if (!this.#waits) return false;
    const { entry, radius } = this.plan;
    const highest = this.#highest();
    let entered = false;
    this.#waiting.forEach((entries, bin) => {
      if (!entries.length || highest[bin] < entry + CLEAR * radius) return;
      const { x, speed } = /** @type {Entry} */ (entries.shift());
      this.arena.add([{ ...DISC, x, y: entry, vy: speed, radius }]);
      this.#discs.push({ bin, number: this.#entered[bin] });
      this.#entered[bin] += 1;
      entered = true;
    });
    return entered;
  }

  /** @returns {number[]} y of the highest disc of each column */
  #highest() {
    const { table } = this.arena;
    const highest = this.#waiting.map(() => Number.POSITIVE_INFINITY);
    for (let row = 0; row < table.n; row += 1) {
      const { bin } = this.#discs[table.id(row)];
      highest[bin] = Math.min(highest[bin], table.pos[4 * row + 1]);
    }
    return highest;
  }

  /** @param {number} part of the last step that has passed, 0 … 1 @returns {Disc[]} */
  look(part) {
    return this.#places().map((disc, i) => {
      const { x, y, angle } = this.#before[i];
      return {
        ...disc, x: x + part * (disc.x - x), y: y + part * (disc.y - y), angle: angle + part * (disc.angle - angle),
      };
    });
  }

  /** @returns {Disc[]} */
  #places() {
    const { table } = this.arena;
    return Array.from({ length: table.n }, (_, row) => {
      const [x, y, arc, radius] = table.pos.subarray(4 * row, 4 * row + 4);
      return { ...this.#discs[table.id(row)], x, y, angle: arc / radius };
    });
  }
}
