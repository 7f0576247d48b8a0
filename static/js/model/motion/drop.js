// A whole drop as motion: its state at any time, from its record and sampled states. Pure.
//
// Between two impacts a ball of the exact solver flies in closed form, so its state is computed.
// While it rides a peg or a wall (from kind 2 or 3 to the next event) it is interpolated between
// sampled states. The stepped solver's balls move in short straight lines between its substeps.

import { flown } from "./flight.js";

export const PEG = 0;
export const WALL = 1;
export const CONTACT_BEGIN = 2;
export const CONTACT_CHANGE = 3;
export const CONTACT_END = 4;
export const LANDING = 5;

const RIDE_FPS = 240; // cubics between samples so close are right to less than a micrometre
const MAX_FPS = 1000;
const MAX_FRAMES = 90_000;

/** @typedef {import("./flight.js").State} State */

/**
 * Something that happened to the ball: kind and index as in the record, the states around it.
 * @typedef {{t: number, kind: number, index: number, before: State, after: State}} Event
 */

/**
 * How densely a drop has to be sampled to be shown truly.
 * @param {any} record
 * @returns {number} frames a second
 */
export function framesNeeded(record) {
  const rides = record.impacts.some(([, , , , , , kind]) => isRide(kind));
  const wanted = record.solver === "stepped" ? record.substeps / record.dt : rides ? RIDE_FPS : 1;
  return Math.min(wanted, MAX_FPS, MAX_FRAMES / Math.max(1, record.duration));
}

/** The motion of one ball from its start to its end. */
export class Motion {
  #pieces;
  #hint = 0;

  /** @param {any} board @param {any} record @param {any} sampled the /frames reply */
  constructor(board, record, sampled) {
    this.board = board;
    this.law = { gravity: board.gravity, drag: board.drag };
    this.duration = record.duration;
    const named = (row) => Object.fromEntries(sampled.fields.map((name, i) => [name, row[i]]));
    const frames = sampled.frames.map(named);
    /** @type {Event[]} */
    this.events = record.impacts.map(([t, x, y, vx, vy, omega, kind, index], i) => {
      const before = { ...named(sampled.before[i]), t };
      return { t, kind, index, before, after: { t, x, y, theta: before.theta, vx, vy, omega } };
    });
    this.start = frames[0];
    this.end = frames[frames.length - 1];
    this.#pieces = pieces(this, frames, record.solver);
  }

  /** Hits of pegs and walls, in order. */
  get hits() {
    return this.events.filter(({ kind }) => kind === PEG || kind === WALL);
  }

  /** @param {number} t seconds @returns {State} */
  stateAt(t) {
    if (t <= this.start.t) return this.start;
    if (t >= this.duration) return this.end;
    const piece = this.#pieces[this.#pieceAt(t)];
    if (piece.how === "flight") return flown(piece.knots[0], t, this.law);
    return between(piece, t);
  }

  /** @param {number} t @returns {number} how many events have happened by then */
  eventsBy(t) {
    let count = 0;
    while (count < this.events.length && this.events[count].t <= t) count += 1;
    return count;
  }

  /**
   * The path as a line through all events.
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

  #pieceAt(t) {
    let i = this.#hint;
    while (i > 0 && this.#pieces[i].from > t) i -= 1;
    while (i < this.#pieces.length - 1 && this.#pieces[i + 1].from <= t) i += 1;
    this.#hint = i;
    return i;
  }
}

/**
 * The part of a line that has been travelled.
 * @param {State[]} line as `Motion.line` makes it
 * @param {State} now
 * @returns {State[]} the same points up to now, and now itself
 */
export function upTo(line, now) {
  let count = 0;
  let end = line.length;
  while (count < end) {
    const middle = (count + end) >> 1;
    if (line[middle].t <= now.t) count = middle + 1;
    else end = middle;
  }
  return [...line.slice(0, count), now];
}

function isRide(kind) {
  return kind === CONTACT_BEGIN || kind === CONTACT_CHANGE;
}

/** A piece of motion from each event (and from the start) to the next one. */
function pieces({ start, end, events }, frames, solver) {
  const made = [];
  let row = 0;
  const knotsUpTo = (from, to) => {
    const knots = [from];
    while (row < frames.length && frames[row].t <= from.t) row += 1;
    while (row < frames.length && frames[row].t < to.t) {
      knots.push(frames[row]);
      row += 1;
    }
    return [...knots, to];
  };
  const add = (from, kind, to) => {
    if (solver === "stepped") made.push({ from: from.t, how: "steps", knots: knotsUpTo(from, to) });
    else if (isRide(kind)) made.push({ from: from.t, how: "ride", knots: knotsUpTo(from, to) });
    else made.push({ from: from.t, how: "flight", knots: [from] });
  };
  add(start, null, events.length ? events[0].before : end);
  events.forEach(({ after, kind }, i) => add(after, kind, events[i + 1]?.before ?? end));
  return made;
}

/** Between two knots of a piece: straight in the stepped solver, cubic on a surface. */
function between({ how, knots }, t) {
  let i = 0;
  let last = knots.length - 1;
  while (last - i > 1) {
    const middle = (i + last) >> 1;
    if (knots[middle].t <= t) i = middle;
    else last = middle;
  }
  const a = knots[i];
  const b = knots[last];
  const span = b.t - a.t;
  const s = span > 0 ? (t - a.t) / span : 1;
  const mix = (from, to) => from + s * (to - from);
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

/** The cubic through both values with both slopes (per whole span). */
function cubic(from, to, slopeFrom, slopeTo, s) {
  const s2 = s * s;
  const s3 = s2 * s;
  return (
    from + (3 * s2 - 2 * s3) * (to - from) + (s3 - 2 * s2 + s) * slopeFrom + (s3 - s2) * slopeTo
  );
}
