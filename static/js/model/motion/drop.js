// The ball's state at any time of a drop, from the drop's record and sampled states. Pure.
//
// Between two impacts of the exact solver the state is computed: the flight has a closed form.
// In sustained contact with a peg or a wall (from kind 2 or 3 to the next event) it is interpolated
// between samples. A ball of the stepped solver moves in a straight line during each substep.

import { flown } from "./flight.js";
import { CONTACT_BEGIN, CONTACT_CHANGE, LANDING, PEG, WALL } from "./kinds.js";

/** @import { Board } from "../board.js" */
/** @import { State } from "./flight.js" */

const CONTACT_RATE = 240; // samples a second: a cubic between two of them is within a micrometre
const MAX_RATE = 1000;
const MAX_SAMPLES = 90_000;

/**
 * @typedef {[t: number, x: number, y: number, vx: number, vy: number, omega: number, kind: number,
 *   index: number]} ImpactRow
 *
 * @typedef {object} DropRecord a drop as the server returns it
 * @property {string} board_digest
 * @property {string} seed
 * @property {number} [x] m, if the player chose the start instead of the seed
 * @property {number} [aim] m, if the player aimed: the seed draws the start around it
 * @property {"exact" | "stepped"} solver
 * @property {number} [dt] s, of the stepped solver
 * @property {number} [substeps]
 * @property {number | null} bin
 * @property {number} score
 * @property {string} [label] the bin's prize, if it has one
 * @property {number} duration s
 * @property {number} x_end m
 * @property {ImpactRow[]} impacts
 * @property {string} digest
 * @property {number | null} [amplification] null if the ball did not land
 * @property {number | null} [x_error] m
 * @property {boolean} [certain]
 *
 * @typedef {{fields: string[], frames: number[][], before: number[][]}} Sampled the /frames reply
 */

/** @typedef {{from: number, how: "flight" | "contact" | "steps", states: State[]}} Stretch of a motion */

/**
 * One event of the drop: kind and index as in the record, the states right before and after it.
 * @typedef {{t: number, kind: number, index: number, before: State, after: State}} DropEvent
 */

/**
 * The sampling rate at which interpolated states are accurate enough to show.
 * @param {Pick<DropRecord, "impacts" | "solver" | "dt" | "substeps" | "duration">} record
 * @returns {number} samples a second
 */
export function samplesNeeded(record) {
  const touches = record.impacts.some(([, , , , , , kind]) => isSustained(kind));
  const { substeps = 1, dt = 1 } = record;
  const wanted = record.solver === "stepped" ? substeps / dt : touches ? CONTACT_RATE : 1;
  return Math.min(wanted, MAX_RATE, MAX_SAMPLES / Math.max(1, record.duration));
}

export class Motion {
  #stretches;

  /** @param {Board} board @param {DropRecord} record @param {Sampled} sampled */
  constructor(board, record, sampled) {
    this.board = board;
    this.law = { gravity: board.gravity, drag: board.drag };
    this.duration = record.duration;
    /** @param {number[]} row */
    const named = (row) => /** @type {State} */ (
      Object.fromEntries(sampled.fields.map((name, i) => [name, row[i]]))
    );
    const samples = sampled.frames.map(named);
    /** @type {DropEvent[]} */
    this.events = record.impacts.map(([t, x, y, vx, vy, omega, kind, index], i) => {
      const before = { ...named(sampled.before[i]), t };
      return { t, kind, index, before, after: { t, x, y, theta: before.theta, vx, vy, omega } };
    });
    this.start = samples[0];
    this.end = samples[samples.length - 1];
    this.#stretches = stretches(this, samples, record.solver);
  }

  /** Impacts on pegs and walls, in order of time. */
  get hits() {
    return this.events.filter(({ kind }) => kind === PEG || kind === WALL);
  }

  /** @param {number} t seconds @returns {State} */
  stateAt(t) {
    if (t <= this.start.t) return this.start;
    if (t >= this.duration) return this.end;
    const stretch = this.#stretches.findLast(({ from }) => from <= t) ?? this.#stretches[0];
    if (stretch.how === "flight") return flown(stretch.states[0], t, this.law);
    return between(stretch, t);
  }

  /** @param {number} t @returns {number} how many events have happened up to t */
  eventsBy(t) {
    return this.events.filter((event) => event.t <= t).length;
  }

  /**
   * Points of the path, all events among them.
   * @param {number} from seconds
   * @param {number} to seconds
   * @param {number} rate points a second between events
   * @returns {State[]}
   */
  line(from, to, rate) {
    const times = [from, to];
    for (const { t } of this.events) if (t > from && t < to) times.push(t);
    for (let i = Math.floor(from * rate) + 1; i / rate < to; i += 1) times.push(i / rate);
    return times.sort((a, b) => a - b).map((t) => this.stateAt(t));
  }
}

/**
 * The part of a path that the ball has travelled.
 * @param {State[]} line from `Motion.line`
 * @param {State} now
 * @returns {State[]} the points up to now, then now itself
 */
export function upTo(line, now) {
  return [...line.filter(({ t }) => t <= now.t), now];
}

/** @param {number} kind */
function isSustained(kind) {
  return kind === CONTACT_BEGIN || kind === CONTACT_CHANGE;
}

/**
 * @param {{start: State, end: State, events: DropEvent[]}} motion
 * @param {State[]} samples
 * @param {string} solver
 * @returns {Stretch[]} from each event (and from the start) to the next one
 */
function stretches({ start, end, events }, samples, solver) {
  /** @type {Stretch[]} */
  const made = [];
  let row = 0;
  /** @param {State} from @param {State} to */
  const statesUpTo = (from, to) => {
    const states = [from];
    while (row < samples.length && samples[row].t <= from.t) row += 1;
    while (row < samples.length && samples[row].t < to.t) {
      states.push(samples[row]);
      row += 1;
    }
    return [...states, to];
  };
  /** @param {State} from @param {number} kind @param {State} to */
  const add = (from, kind, to) => {
    if (solver === "stepped") made.push({ from: from.t, how: "steps", states: statesUpTo(from, to) });
    else if (isSustained(kind)) made.push({ from: from.t, how: "contact", states: statesUpTo(from, to) });
    else made.push({ from: from.t, how: "flight", states: [from] });
  };
  add(start, LANDING, events.length ? events[0].before : end);
  events.forEach(({ after, kind }, i) => add(after, kind, events[i + 1]?.before ?? end));
  return made;
}

/**
 * Interpolates between the states of a stretch: linearly in the stepped solver, by cubics on a surface.
 * @param {Stretch} stretch
 * @param {number} t
 */
function between({ how, states }, t) {
  const later = states.findIndex((state, i) => i > 0 && state.t > t);
  const [a, b] = later < 0 ? states.slice(-2) : [states[later - 1], states[later]];
  const span = b.t - a.t;
  const s = span > 0 ? (t - a.t) / span : 1;
  /** @param {number} from @param {number} to */
  const mix = (from, to) => from + s * (to - from);
  /** @param {number} from @param {number} to @param {number} vFrom @param {number} vTo */
  const place = (from, to, vFrom, vTo) =>
    how === "steps" ? mix(from, to) : cubic(from, to, vFrom * span, vTo * span, s);
  return {
    t,
    x: place(a.x, b.x, a.vx, b.vx),
    y: place(a.y, b.y, a.vy, b.vy),
    theta: place(a.theta, b.theta, a.omega, b.omega),
    vx: mix(a.vx, b.vx),
    vy: mix(a.vy, b.vy),
    omega: mix(a.omega, b.omega),
  };
}

/**
 * The cubic with given values and slopes at both ends (slopes per span), at s in 0 … 1.
 * @param {number} from
 * @param {number} to
 * @param {number} slopeFrom
 * @param {number} slopeTo
 * @param {number} s
 */
function cubic(from, to, slopeFrom, slopeTo, s) {
  const s2 = s * s;
  const s3 = s2 * s;
  return (
    from + (3 * s2 - 2 * s3) * (to - from) + (s3 - 2 * s2 + s) * slopeFrom + (s3 - s2) * slopeTo
  );
}
