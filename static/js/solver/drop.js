// One computed drop: its outcome, impacts, digest, record, and the ball's state at any time.

import { dropDigest, PHYSICS_VERSION } from "./digest.js";
import { ParameterError } from "./errors.js";

/** @import { ImpactRow } from "../model/motion/drop.js" */
/** @import { WholeBoard } from "./input/values.js" */
/** @import { Traced } from "./kernels.js" */

/**
 * @typedef {{t: number, x: number, y: number, theta: number, vx: number, vy: number, omega: number}} BallState
 *   s, m, rad, m/s, rad/s
 *
 * @typedef {{board: WholeBoard, digest: string, seed: bigint | null, x: number, explicit: boolean,
 *   aim: number | null, traced: Traced}} Made digest: the board's; explicit: whether x was given, instead of
 *   drawn by the seed; aim: m, if given
 */

const LANDED = 0;
const REASONS = [
  "",
  "wedged: at rest between two surfaces",
  "balanced: at rest on a surface",
  "escaped: too far from the board",
  "event budget: still moving after 100,000 events",
  "time budget: still moving after 1,000 s",
  "search budget: nothing hit within a million search windows of one flight",
  "impulse budget: still bouncing between two surfaces after 1,000 impulses at one time",
  "solver error: the computed path left its surface or gained energy",
];

/** A computed drop, made by `Solver.drop`. */
export class Drop {
  #made;
  #sample;
  /** @type {string | null} */
  #digest = null;

  /** @param {Made} made @param {(times: number[]) => number[][]} sample */
  constructor(made, sample) {
    this.#made = made;
    this.#sample = sample;
  }

  /** Where the ball started, m. */
  get xStart() {
    return this.#made.x;
  }

  /** Number of the bin, from 0 on the left; null if the ball did not land. */
  get bin() {
    const { outcome, bin } = this.#made.traced;
    return outcome === LANDED ? bin : null;
  }

  /** The reason why the ball did not land, null if it did. */
  get unsettled() {
    const { outcome } = this.#made.traced;
    return outcome === LANDED ? null : REASONS[outcome];
  }

  /** The bin's multiplier; 1 if the ball did not land, so that the stake is returned. */
  get score() {
    return this.bin === null ? 1 : this.#made.board.bins.multipliers[this.bin];
  }

  /** The text of the bin's label, null without one. */
  get label() {
    const { bin } = this;
    return bin === null ? null : this.#made.board.bins.labels?.[bin]?.text ?? null;
  }

  /** Time from the start to the end, s. */
  get duration() {
    return this.#made.traced.end[0];
  }

  /** The x at which the centre crossed the bins' line, or ended without landing, m. */
  get xEnd() {
    return this.#made.traced.end[1];
  }

  /** All events in order, each: t, x, y, vx, vy, omega right after it, kind, number of the surface or bin. */
  get impacts() {
    return /** @type {ImpactRow[]} */ (this.#made.traced.impacts);
  }

  /** SHA-256 of board, start and every event: 64 hexadecimal digits, the same as the server's. */
  get digest() {
    const { board, digest, x, traced } = this.#made;
    this.#digest ??= dropDigest(digest, { x, y: board.drop.y }, traced);
    return this.#digest;
  }

  /** The board's digest, 64 hexadecimal digits. */
  get boardDigest() {
    return this.#made.digest;
  }

  /**
   * The ball's state at each of these times. After the end it stays in its last state.
   * @param {number[]} times s since the start; throws a ParameterError if one is negative
   * @returns {BallState[]}
   */
  states(times) {
    const bad = times.find((time) => !(time >= 0));
    if (bad !== undefined) {
      throw new ParameterError(`time ${bad} is before the start of the drop`, "times");
    }
    const { end } = this.#made.traced;
    const { duration } = this;
    const rows = this.#sample(times.filter((time) => time < duration));
    let next = 0;
    return times.map((time) => {
      const row = time < duration ? rows[next] : end;
      if (row !== end) next += 1;
      const [, x, y, vx, vy, theta, omega] = row;
      return { t: time, x, y, theta, vx, vy, omega };
    });
  }

  /**
   * The state right before each event: at the largest double below its time. For the second of two
   * events at the same time, it is the state after the first.
   * @returns {BallState[]}
   */
  before() {
    const { impacts } = this;
    const states = this.states(impacts.map(([t]) => justBefore(t)));
    return states.map((state, i) => {
      const [t, x, y, vx, vy, omega] = impacts[i - 1] ?? [];
      return t === impacts[i][0] ? { ...state, t, x, y, vx, vy, omega } : state;
    });
  }

  /** What JSON.stringify writes: the record. */
  toJSON() {
    return this.record();
  }

  /** The drop's record, as `plinko drop --json` and REST return it. */
  record() {
    const { digest, seed, explicit, aim, board } = this.#made;
    return {
      board,
      board_digest: digest,
      seed: seed === null ? null : String(seed),
      ...(explicit ? { x: this.xStart } : {}),
      ...(aim === null ? {} : { aim }),
      solver: "exact",
      physics_version: PHYSICS_VERSION,
      bin: this.bin,
      score: this.score,
      ...(this.label === null ? {} : { label: this.label }),
      duration: this.duration,
      x_end: this.xEnd,
      impacts: this.impacts,
      digest: this.digest,
    };
  }
}

/** @param {number} t 0 or more @returns {number} the largest double below t; 0 for 0 */
function justBefore(t) {
  if (t === 0) return 0;
  const view = new DataView(new ArrayBuffer(8));
  view.setFloat64(0, t);
  view.setBigInt64(0, view.getBigInt64(0) - 1n);
  return view.getFloat64(0);
}
