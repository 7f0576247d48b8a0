// The balls of one room as this page knows them: events and snapshots in, scenes at a time out.

import { emptyScene } from "./board-view.js";
import { Path } from "./path.js";

const PEG = 0;
const SINK_SECONDS = 0.25; // a landed ball is still seen falling into its pocket
const FLASH_SECONDS = 0.35;
const HIT_SECONDS = 1.4;
const TRAIL_POINTS = 14;
const TRAIL_STEP = 1 / 90; // s between points of a trail
const LOUD = 3; // m/s: an impact of this speed flashes at full strength

/**
 * @typedef {object} Ball
 * @property {number} id
 * @property {string} seed
 * @property {number} x start, metres
 * @property {boolean} explicit the start was chosen, not drawn from the seed
 * @property {number} start table time, s
 * @property {boolean} mine
 * @property {Path} path
 * @property {any} landed the landed event, once it came
 * @property {boolean} settled its landing has been shown
 * @property {Float64Array} trail
 */

/** Balls in flight, recent contacts and recent hits of one room. Table time is tick / rate. */
export class Table {
  /** @type {Map<number, Ball>} */
  balls = new Map();
  #byWireId = new Map();
  #contacts = [];
  #hits = [];
  /** The path of our last landed ball, for those who do not want to see it move. */
  lastPath = null;

  /** @param {any} hello */
  constructor(hello) {
    this.board = hello.board;
    this.rate = hello.tick_rate;
    this.law = { gravity: hello.board.gravity, drag: hello.board.drag };
    for (const ball of hello.balls) {
      this.#add(ball, { mine: false, explicit: false, fresh: ball.tick >= hello.tick });
    }
  }

  /** @param {any} event @param {boolean} mine @returns {Ball} */
  accept(event, mine) {
    return this.#add(event, { mine, explicit: event.explicit_x, fresh: true });
  }

  /** True while something is in flight or still to be shown. */
  get busy() {
    return this.balls.size > 0 || this.#contacts.length > 0 || this.#hits.length > 0;
  }

  get flying() {
    return this.balls.size > 0;
  }

  /** @param {import("./protocol.js").Snapshot} snapshot */
  applySnapshot(snapshot) {
    const t = snapshot.tick / this.rate;
    for (let i = 0; i < snapshot.count; i += 1) {
      const ball = this.#byWireId.get(snapshot.ids[i]);
      if (!ball || ball.landed || t <= ball.start) continue;
      ball.path.add({
        t,
        x: snapshot.x[i],
        y: snapshot.y[i],
        angle: snapshot.angle[i],
        vx: snapshot.vx[i],
        vy: snapshot.vy[i],
        vIn: true,
        vOut: true,
        bounced: snapshot.bounced[i] === 1,
      });
    }
  }

  /** @param {any} event contact */
  applyContact(event) {
    const ball = this.balls.get(event.ball);
    if (!ball) return;
    const t = ball.start + event.t;
    if (ball.path.knots.length) ball.path.add(place(t, event.x, event.y));
    this.#contacts.push({ t, kind: event.kind, index: event.index, speed: event.speed });
  }

  /** @param {any} event landed @returns {Ball | undefined} */
  applyLanded(event) {
    const ball = this.balls.get(event.ball);
    if (!ball) return undefined;
    ball.landed = event;
    ball.end = ball.start + event.t;
    if (event.bin !== null && ball.path.knots.length) {
      ball.sinkFrom = ball.path.knots.at(-1);
      ball.path.add(place(ball.end, event.x_end, this.board.bins.y));
    }
    return ball;
  }

  /**
   * Balls whose landing is due; each is given once.
   * @param {number} until landings up to this table time are due, s
   * @param {number} wall local time at which their bins light up, s
   * @returns {Ball[]}
   */
  settle(until, wall) {
    const due = [];
    for (const ball of this.balls.values()) {
      if (!ball.landed || ball.settled || until < ball.end) continue;
      ball.settled = true;
      if (ball.landed.bin !== null) {
        this.#hits.push({ since: wall, bin: ball.landed.bin, score: ball.landed.score });
      }
      if (ball.mine) this.lastPath = ball.path;
      due.push(ball);
    }
    return due;
  }

  /**
   * All that moves; what is over by then is forgotten.
   * @param {number} t table time, s
   * @param {number} wall local time, s: table time stands still while a room sleeps
   * @returns {import("./board-view.js").Scene}
   */
  sceneAt(t, wall) {
    const scene = emptyScene();
    this.forget(t, wall);
    for (const ball of this.balls.values()) {
      if (ball.path.knots.length && t >= ball.path.start) scene.balls.push(this.#pose(ball, t));
    }
    for (const contact of this.#contacts) {
      const age = (t - contact.t) / FLASH_SECONDS;
      const peg = this.board.pegs[contact.index];
      if (contact.kind !== PEG || age < 0 || !peg) continue;
      scene.flashes.push({ ...peg, age, strength: Math.min(1, contact.speed / LOUD) });
    }
    for (const { since, bin, score } of this.#hits) {
      scene.hits.push({ bin, score, age: Math.max(0, wall - since) / HIT_SECONDS });
    }
    return scene;
  }

  #add({ ball: id, seed, x, tick }, { mine, explicit, fresh }) {
    const start = tick / this.rate;
    const ball = {
      id, seed, x, explicit, start, mine, path: new Path(this.law), landed: null, settled: false,
      end: Number.POSITIVE_INFINITY, sinkFrom: null, trail: new Float64Array(2 * TRAIL_POINTS),
    };
    if (fresh) {
      ball.path.add({
        ...place(start, x, this.board.drop.y), angle: 0, vIn: true, vOut: true,
      });
    }
    this.balls.set(id, ball);
    this.#byWireId.set(id % 65536, ball);
    return ball;
  }

  /** @param {number} t table time, s @param {number} wall local time, s */
  forget(t, wall) {
    for (const ball of this.balls.values()) {
      if (!ball.settled || t < ball.end + SINK_SECONDS) continue;
      this.balls.delete(ball.id);
      this.#byWireId.delete(ball.id % 65536);
    }
    this.#contacts = this.#contacts.filter((contact) => t < contact.t + FLASH_SECONDS);
    this.#hits = this.#hits.filter((hit) => wall < hit.since + HIT_SECONDS);
  }

  #pose(ball, t) {
    const pose = { x: 0, y: 0, angle: 0, mine: ball.mine, trail: ball.trail, trailCount: 0 };
    this.#place(ball, t, pose);
    for (let i = 0; i < TRAIL_POINTS; i += 1) {
      const then = t - i * TRAIL_STEP;
      if (then < ball.path.start) break;
      const { x, y } = this.#place(ball, then, this.#scratch);
      ball.trail[2 * i] = x;
      ball.trail[2 * i + 1] = y;
      pose.trailCount = i + 1;
    }
    return pose;
  }

  #scratch = { x: 0, y: 0, angle: 0 };

  #place(ball, t, out) {
    if (t <= ball.end || !ball.sinkFrom) return ball.path.poseAt(t, out);
    // Past the end of the simulation it keeps its last velocity while its pocket swallows it.
    const { vx, vy } = ball.sinkFrom;
    ball.path.poseAt(ball.end, out);
    out.x += vx * (t - ball.end) * 0.5;
    out.y += Math.max(vy, 1.5) * (t - ball.end);
    return out;
  }
}

/** A moment known by its place alone. */
function place(t, x, y) {
  return { t, x, y, angle: 0, vx: 0, vy: 0, vIn: false, vOut: false, bounced: false };
}
