// The balls of one room: takes its events and snapshots, and makes the scene at any table time.

import { Path } from "../motion/path.js";
import { colourOf } from "../player/colour.js";
import { emptyScene } from "../scene.js";
import { ImpactQueue } from "./impact-queue.js";
import { shownEnd, timeInFall, timeSeen } from "./pace.js";
import { PathFeed } from "./path-feed.js";

/** @import { Accepted, BallStart, BriefAccepted, BriefLanded, Contact, Hello, Landed, Snapshot, Tag } from "../messages.js" */
/** @import { Point } from "../board.js" */
/** @import { BinHit, Scene, SceneBall } from "../scene.js" */
/** @import { QueuedImpact } from "./impact-queue.js" */
/** @import { Solved } from "./path-feed.js" */
/** @import { Keyframe, Law, Pose } from "../motion/interpolate.js" */

const SINK_SECONDS = 0.25; // a landed ball is still shown sinking into its pocket
const HIT_SECONDS = 1.4;
const TRAIL_POINTS = 8;
const OWN_TRAIL_POINTS = 14; // longer, because players follow their own balls
const TRAIL_STEP = 1 / 55; // s between points of a trail
const KEPT_SECONDS = 0.3; // of a path before the shown time: for the trail and for late contacts
const QUIET = 0.05; // m/s; no stream reports slower impacts
const HEARD_SECONDS = 0.5; // an impact that is later than this is neither shown nor played
const MOST_TRACED = 20_000; // points of a path that is kept whole: minutes of a fall
const MOST_KEYFRAMES = 600; // of one ball, while the page does not draw (a hidden tab)

/**
 * @typedef {object} Ball
 * @property {number} id
 * @property {string} seed
 * @property {number} x start, metres
 * @property {boolean} explicit the start was chosen, not drawn from the seed
 * @property {number} [aim] m, if the player aimed
 * @property {number} start table time, s
 * @property {boolean} mine
 * @property {number} [stake] credits, if this player staked them on it
 * @property {number} [staked] minor units, whoever staked them
 * @property {number} [visitor] its owner, if known
 * @property {Tag} [tag] of its drop
 * @property {string} [by] its owner's name
 * @property {Path} path
 * @property {Solved | null} solved its drop, if this page computed it
 * @property {PathFeed | null} feed makes the path, if it is known before it happens
 * @property {Landed | null} landed the table's event, null until it arrives
 * @property {number} end table time of its landing, s; infinite until it is known
 * @property {{vx: number, vy: number} | null} sink velocity at the landing in a bin, m/s
 * @property {Passed} passed called with each stretch of its path that time has passed
 * @property {number} pace how many times faster than the table's clock its fall is shown
 * @property {Landed | null} outcome the landing that was shown, null until then
 * @property {boolean} settled whether its landing has been shown and the table has sent it
 * @property {Point[] | null} trace its whole path, if kept
 * @property {SceneBall} pose as last drawn
 */

/** @typedef {(a: Keyframe, b: Keyframe, law: Law) => void} Passed */
/** @typedef {(start: {seed: string, x?: number, aim?: number}) => Solved} Solve */
/** @typedef {BinHit & {since: number}} LitBin since: local time, s */

/**
 * @typedef {Pick<Hello, "board" | "tick_rate" | "tick" | "stream" | "balls">} TableStart
 */

/** Balls in flight, impacts and recent hits of one room. Table time is tick / rate. */
export class Table {
  /** @type {Map<number, Ball>} */
  balls = new Map();
  /** Impacts that became due with the last scene, for the sound. @type {QueuedImpact[]} */
  heard = [];
  /** The pace of this player's next balls, see `PACES`. */
  pace = 1;
  /** Whether to keep the whole paths of this player's balls. */
  tracing = false;
  /** The path of this player's last landed ball, if traced. @type {Point[] | null} */
  lastTrace = null;
  /** Called with each stretch of a path that time has passed. @type {Passed | null} */
  onPassed = null;
  /** @type {Map<number, Ball>} */
  #byWireId = new Map();
  /** @type {LitBin[]} */
  #hits = [];

  /**
   * @param {TableStart} hello
   * @param {Solve | null} [solve] computes a ball's whole path from its start, in the stream `seeds`
   */
  constructor(hello, solve = null) {
    this.solve = solve;
    this.board = hello.board;
    this.rate = hello.tick_rate;
    this.law = { gravity: hello.board.gravity, drag: hello.board.drag };
    this.impacts = new ImpactQueue(hello.board.pegs);
    for (const ball of hello.balls) {
      const from = hello.tick / this.rate - KEPT_SECONDS;
      this.#add(ball, { mine: false, explicit: false, fresh: ball.tick >= hello.tick, from });
    }
  }

  /** @param {Accepted | BriefAccepted} event @param {boolean} mine @returns {Ball} */
  accept(event, mine) {
    const from = event.tick / this.rate;
    const explicit = event.explicit_x ?? false;
    const ball = this.#add(event, { mine, explicit, fresh: true, from });
    ball.aim = event.aim;
    ball.staked = event.stake;
    ball.visitor = event.visitor;
    if (!mine && event.receipt && !event.colour) ball.pose.colour = colourOf(event.receipt.receipt.session);
    return ball;
  }

  /** True while something is in flight or still shown. */
  get busy() {
    return this.balls.size > 0 || this.impacts.busy || this.#hits.length > 0;
  }

  /** Whether the room's clock runs: it stops when all balls have landed. */
  get awake() {
    for (const ball of this.balls.values()) if (!ball.landed) return true;
    return false;
  }

  get flying() {
    return this.balls.size > 0;
  }

  /** Whether the table has sent every landing and this page has shown it. */
  get shown() {
    for (const ball of this.balls.values()) if (!ball.settled) return false;
    return true;
  }

  /** @param {Snapshot} snapshot */
  applySnapshot(snapshot) {
    const t = snapshot.tick / this.rate;
    for (const { id, x, y, angle, vx, vy, bounced } of snapshot.balls) {
      const ball = this.#byWireId.get(id);
      if (!ball || ball.landed || t <= ball.start) continue;
      ball.path.add({ t, x, y, angle, vx, vy, bounced, vIn: true, vOut: true });
    }
  }

  /** @param {Contact} event */
  applyContact(event) {
    const ball = this.balls.get(event.ball);
    if (!ball) return;
    const t = ball.start + event.t;
    // The part of the path that has already been shown does not change.
    if (ball.path.keyframes.length && t > ball.path.start) ball.path.add(place(t, event.x, event.y));
    this.impacts.add(t, event);
  }

  /**
   * @param {Landed | BriefLanded} event a brief one is completed from the path that this page computed
   * @returns {boolean} false, and nothing changes, if this page computed another path than the table
   */
  applyLanded(event) {
    const ball = this.balls.get(event.ball);
    if (!ball) return true;
    const landed = "t" in event ? event : ball.solved && completed(event, ball.solved);
    if (!landed) return false;
    ball.landed = landed;
    ball.end = ball.start + landed.t;
    if (!ball.feed) this.#close(ball, landed);
    return true;
  }

  /**
   * Returns each ball twice, once in each list: in `seen` when its landing is to be shown, in `settled`
   * when the table has sent the landing too. A ball with a faster pace is seen before it settles.
   * @param {number} until landings up to this table time are due, s
   * @param {number | null} wall local time at which their bins light up, s; null if the page is hidden
   * @returns {{seen: Ball[], settled: Ball[]}}
   */
  settle(until, wall) {
    /** @type {{seen: Ball[], settled: Ball[]}} */
    const due = { seen: [], settled: [] };
    for (const ball of this.balls.values()) {
      if (!ball.outcome && until >= shownEnd(ball)) {
        // A ball of a faster pace has a landing that this page computed, before the table sends it.
        const { id, pace, solved } = ball;
        const early = pace === 1 || !solved ? null : completed({ type: "landed", ball: id, digest: solved.digest }, solved);
        ball.outcome = ball.landed ?? early;
        if (ball.outcome) this.#see(ball, ball.outcome, wall);
        if (ball.outcome) due.seen.push(ball);
      }
      if (ball.settled || !ball.outcome || !ball.landed) continue;
      ball.settled = true;
      due.settled.push(ball);
    }
    return due;
  }

  /** @param {Ball} ball @param {Landed} outcome @param {number | null} wall */
  #see(ball, outcome, wall) {
    // The score is written above the bin only for this player's practice balls: a payout flies to the
    // balance instead.
    if (wall !== null) this.#light(outcome, ball.mine && ball.stake === undefined, wall);
    if (!ball.mine || !ball.trace) return;
    ball.feed?.until(ball.end);
    this.#pass(ball, Number.POSITIVE_INFINITY);
    this.lastTrace = ball.trace;
  }

  /**
   * The scene at a time. Forgets balls and hits that are over.
   * @param {number} t table time, s
   * @param {number} wall local time, s, for the lights of bins: table time stops while a room sleeps
   * @returns {Scene}
   */
  sceneAt(t, wall) {
    const scene = emptyScene();
    this.forget(t, wall);
    this.heard = this.impacts.advance(t);
    for (const ball of this.balls.values()) {
      const own = timeInFall(ball, t);
      // A ball whose landing was shown early stays invisible until the table sends the landing.
      if (own > ball.end + SINK_SECONDS && ball.outcome) continue;
      ball.feed?.until(timeInFall(ball, t + 1 / this.rate), (at, impact) => {
        const then = timeSeen(ball, at);
        if (!Number.isFinite(ball.pace) || then < t - HEARD_SECONDS || impact.speed < QUIET) return;
        this.impacts.add(then, impact);
      });
      if (!ball.path.keyframes.length || own < ball.path.start) continue;
      scene.balls.push(this.#pose(ball, own));
    }
    scene.flashes = this.impacts.lit;
    for (const hit of this.#hits) hit.age = Math.max(0, wall - hit.since) / HIT_SECONDS;
    scene.hits = this.#hits;
    return scene;
  }

  /** @param {number} t table time, s @param {number} wall local time, s */
  forget(t, wall) {
    for (const ball of this.balls.values()) {
      if (ball.settled && t >= shownEnd(ball) + SINK_SECONDS) {
        this.#pass(ball, Number.POSITIVE_INFINITY);
        this.balls.delete(ball.id);
        this.#byWireId.delete(ball.id % 65536);
      } else this.#pass(ball, timeInFall(ball, t) - KEPT_SECONDS);
    }
    this.#hits = this.#hits.filter(({ since }) => wall < since + HIT_SECONDS);
  }

  /**
   * @param {Omit<BallStart, "x"> & {x?: number, aim?: number}} ballStart
   * @param {{mine: boolean, explicit: boolean, fresh: boolean, from: number}} given from: table time
   *   at which its path begins, s
   */
  #add({ ball: id, seed, x: given, aim, tick, ...rest }, { mine, explicit, fresh, from }) {
    const start = tick / this.rate;
    const path = new Path(this.law, MOST_KEYFRAMES);
    const { board, rate } = this;
    const solved = this.solve?.(given === undefined ? { seed, aim } : { seed, x: given });
    const x = solved?.xStart ?? given ?? 0;
    const tag = tagOf(rest);
    /** @type {Ball} */
    const ball = {
      id, seed, x, aim, explicit, start, mine, path, landed: null, outcome: null, settled: false,
      pace: mine && solved ? this.pace : 1,
      end: Number.POSITIVE_INFINITY, sink: null, solved: solved ?? null,
      feed: solved ? new PathFeed(path, solved, board, { start, from, rate }) : null,
      trace: mine && this.tracing ? [{ x, y: board.drop.y }] : null,
      ...(tag && { tag }),
      pose: {
        x, y: board.drop.y, angle: 0, mine, trail: [], id, ...tag,
      },
      passed: (a, b, law) => {
        if (ball.trace && ball.trace.length < MOST_TRACED) ball.trace.push({ x: b.x, y: b.y });
        this.onPassed?.(a, b, law);
      },
    };
    if (ball.feed) Object.assign(ball, { end: ball.feed.end, sink: ball.feed.sink });
    else if (fresh) path.add({ ...place(start, x, board.drop.y), vIn: true, vOut: true });
    this.balls.set(id, ball);
    this.#byWireId.set(id % 65536, ball);
    return ball;
  }

  /** Ends a path at the place of the landing. @param {Ball} ball @param {Landed} landed */
  #close(ball, { bin, x_end: x }) {
    const { path, end } = ball;
    const last = path.keyframes.at(-1);
    if (bin === null || !last) return;
    ball.sink = { vx: last.vx, vy: last.vy };
    path.add(place(end, x, this.board.bins.y));
  }

  /** @param {Ball} ball @param {number} before */
  #pass(ball, before) {
    ball.path.forget(before, ball.passed);
  }

  /**
   * Lights a bin. Each bin has at most one light, so that many landings at once cost no more to draw.
   * @param {Landed} landed
   * @param {boolean} ticket
   * @param {number} wall
   */
  #light({ bin, score }, ticket, wall) {
    if (bin === null) return;
    let hit = this.#hits.find((one) => one.bin === bin);
    if (!hit) {
      hit = { bin, score, since: wall, age: 0, ticket };
      this.#hits.push(hit);
    }
    hit.score = score;
    hit.since = wall;
    hit.ticket = ticket;
  }

  /** @param {Ball} ball @param {number} t */
  #pose(ball, t) {
    const { pose, path } = ball;
    const { x, y, angle } = this.#place(ball, t);
    Object.assign(pose, { x, y, angle, mine: ball.mine, trail: [{ x, y }] });
    const most = ball.mine ? OWN_TRAIL_POINTS : TRAIL_POINTS;
    for (let i = 1; i < most; i += 1) {
      const then = t - i * TRAIL_STEP;
      if (then < path.start) break;
      pose.trail.push(this.#place(ball, then));
    }
    return pose;
  }

  /** @param {Ball} ball @param {number} t @returns {Pose} */
  #place({ path, end, sink }, t) {
    if (t <= end || !sink) return path.poseAt(t);
    // The simulation ends at the bin's line. The picture continues it while the pocket swallows the ball.
    const { x, y, angle } = path.poseAt(end);
    return { x: x + sink.vx * (t - end) * 0.5, y: y + Math.max(sink.vy, 1.5) * (t - end), angle };
  }
}

/**
 * A brief landing with the values that this page computed.
 * @param {BriefLanded} event
 * @param {Solved} solved
 * @returns {Landed | null} null if the digests differ, as the table then computed another path
 */
function completed(event, { bin, score, duration: t, xEnd: x_end, unsettled, digest }) {
  return digest.startsWith(event.digest) ? { ...event, bin, score, t, x_end, unsettled } : null;
}

/** @param {Tag} start @returns {Tag | undefined} */
function tagOf({ name, colour }) {
  return name || colour ? { ...(name && { name }), ...(colour && { colour }) } : undefined;
}

/** A moment without a velocity. @param {number} t @param {number} x @param {number} y */
function place(t, x, y) {
  return { t, x, y, vIn: false, vOut: false };
}
