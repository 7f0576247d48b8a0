// A live room whose balls touch each other: its state, its pictures in time, and what it is told.

import { socketUrl } from "../net/api.js";
import { TickClock } from "../net/tick-clock.js";
import { Connection } from "../net/connection.js";
import { poseBetween, shortestTurn } from "../model/motion/interpolate.js";
import { decodeEvents, decodeSnapshot, ProtocolError } from "../net/protocol.js";

const KEPT = 24; // snapshots: more than the clock ever holds the picture back
const DRAG_MS = 33; // between two places of the hand
const HOLD_MS = 1000; // a hand that rests says so this often, or it would lapse

/**
 * @typedef {object} SandboxListener
 * @property {(hello: any) => void} onRoom the room is there, there again, or begun anew
 * @property {(state: "connecting" | "live" | "asleep" | "paused" | "reconnecting" | "closed",
 *   detail?: string) => void} onState
 * @property {(event: any) => void} onEvent placed, edited, removed, settings, diagnostics, landed
 * @property {(message: string) => void} onError
 * @property {() => void} onChange there is something new to draw
 */

/** @typedef {{id: number, x: number, y: number, angle: number, radius: number, asleep: boolean}} Seen */

/** One room, through reconnections. */
export class SandboxRoom {
  hello = null;
  paused = false;
  /** What each ball is made of. @type {Map<number, {radius: number, density: number, restitution: number, friction: number}>} */
  made = new Map();
  #snapshots = [];
  #state = "connecting";
  #watching = false;
  #quiet = 0;
  #drag = null;
  #a = knot();
  #b = knot();
  #pose = { x: 0, y: 0, angle: 0 };

  /** @param {string} room @param {SandboxListener} listener */
  constructor(room, listener) {
    this.room = room;
    this.listener = listener;
    this.connection = new Connection(socketUrl(room), {
      onText: (text) => this.#read(() => {
        for (const event of decodeEvents(text)) this.#take(event);
      }),
      onBytes: (bytes) => this.#read(() => this.#snapshot(bytes)),
      onLost: (waitMs) => this.#setState("reconnecting", `${Math.max(1, Math.round(waitMs / 1000))} s`),
      onRefused: (reason) => this.#setState("closed", reason),
    });
  }

  /** @param {object} message @returns {boolean} false when there is no line */
  send(message) {
    return this.hello !== null && this.connection.send(message);
  }

  /** Diagnostics from now on, or no more: nobody computes them for a page that is not looked at. */
  watch(wanted) {
    this.#watching = wanted;
    this.send({ type: "watch", diagnostics: wanted });
  }

  /** Leads a ball to a place; as often as the room may be told. */
  drag(ball, x, y) {
    const first = this.#drag?.ball !== ball;
    if (first) this.letGo();
    this.#drag ??= { ball, sent: 0, timer: 0 };
    Object.assign(this.#drag, { x, y });
    const wait = DRAG_MS - (performance.now() - this.#drag.sent);
    if (wait <= 0) this.#sendDrag();
    else this.#drag.timer ||= setTimeout(() => this.#sendDrag(), wait);
  }

  /** @returns {number | null} the ball that is held */
  get holding() {
    return this.#drag?.ball ?? null;
  }

  /** Lets go of what is held; it flies on. */
  letGo() {
    if (!this.#drag) return;
    clearTimeout(this.#drag.timer);
    clearTimeout(this.#drag.again);
    if (performance.now() - this.#drag.sent < 10 * DRAG_MS) {
      this.send({ type: "drag", ball: this.#drag.ball, x: this.#drag.x, y: this.#drag.y });
    }
    this.send({ type: "release", ball: this.#drag.ball });
    this.#drag = null;
  }

  #sendDrag() {
    const drag = this.#drag;
    drag.timer = 0;
    drag.sent = performance.now();
    this.send({ type: "drag", ball: drag.ball, x: drag.x, y: drag.y });
    clearTimeout(drag.again);
    drag.again = setTimeout(() => this.#drag === drag && this.#sendDrag(), HOLD_MS);
  }

  /**
   * Where the balls are at a local time.
   * @param {number} nowMs
   * @param {(ball: Seen) => void} see called for each, with the same object
   */
  look(nowMs, see) {
    const last = this.#snapshots.at(-1);
    if (!last) return;
    const tick = this.clock.renderTick(nowMs);
    let at = this.#snapshots.length - 1;
    while (at > 0 && this.#snapshots[at - 1].tick >= tick) at -= 1;
    const to = this.#snapshots[at];
    const from = at > 0 && tick < to.tick ? this.#snapshots[at - 1] : to;
    const seen = { id: 0, x: 0, y: 0, angle: 0, radius: 0, asleep: false };
    for (let i = 0, j = 0; i < to.count; i += 1) {
      const id = to.ids[i];
      while (j < from.count && from.ids[j] < id) j += 1;
      const made = this.made.get(id);
      if (!made) continue;
      const before = from !== to && from.ids[j] === id ? j : -1;
      const pose = before < 0 ? this.#as(to, i) : this.#between(from, before, to, i, tick);
      Object.assign(seen, pose);
      seen.id = id;
      seen.radius = made.radius;
      seen.asleep = to.asleep[i] === 1;
      see(seen);
    }
  }

  /** Whether the picture still changes by itself. */
  get busy() {
    return performance.now() - this.#quiet < 600;
  }

  close() {
    this.letGo();
    this.connection.close();
  }

  #as(snapshot, i) {
    const pose = this.#pose;
    pose.x = snapshot.x[i];
    pose.y = snapshot.y[i];
    pose.angle = snapshot.angle[i];
    return pose;
  }

  #between(from, i, to, j, tick) {
    const still = from.x[i] === to.x[j] && from.y[i] === to.y[j] && from.angle[i] === to.angle[j];
    if (still) return this.#as(to, j);
    const [a, b] = [fill(this.#a, from, i, this.rate), fill(this.#b, to, j, this.rate)];
    const t = tick / this.rate;
    if (to.tick - from.tick <= 2) {
      const pose = poseBetween(a, b, t, this.law, this.#pose);
      // Between balls that lean on each other flight explains little: stay on the way between.
      if (inside(pose.x, a.x, b.x) && inside(pose.y, a.y, b.y)) return pose;
    }
    const s = (tick - from.tick) / (to.tick - from.tick);
    this.#pose.x = a.x + s * (b.x - a.x);
    this.#pose.y = a.y + s * (b.y - a.y);
    this.#pose.angle = a.angle + s * shortestTurn(a.angle, b.angle);
    return this.#pose;
  }

  /** A server that speaks another protocol will go on doing so: no use in coming back. */
  #read(message) {
    try {
      message();
    } catch (error) {
      if (!(error instanceof ProtocolError)) throw error;
      this.connection.close();
      this.#setState("closed", error.message);
    }
  }

  #take(event) {
    if (event.type === "hello") this.#greeted(event);
    else if (event.type === "error") this.listener.onError(event.detail);
    else this.#happened(event);
  }

  #greeted(hello) {
    if (!hello.arena) {
      this.connection.close();
      this.#setState("closed", `The balls of room ${hello.room} do not touch each other.`);
      return;
    }
    this.connection.settled();
    this.hello = hello;
    this.rate = hello.tick_rate;
    this.clock = new TickClock({ rate: hello.tick_rate });
    this.#snapshots = [];
    this.#drag = null;
    this.scale = { extent: hello.extent, velocityScale: hello.velocity_scale };
    const { ball, ...columns } = hello.arena.balls;
    this.made = new Map(ball.map((id, i) => [
      id & 0xffff,
      Object.fromEntries(Object.entries(columns).map(([name, values]) => [name, values[i]])),
    ]));
    this.#setSettings(hello.arena);
    this.#quiet = performance.now();
    this.listener.onRoom(hello);
    if (this.#watching) this.watch(true);
  }

  #setSettings({ settings, paused }) {
    this.settings = settings;
    this.paused = paused;
    this.law = { gravity: settings.gravity, drag: settings.drag };
    this.#setState(paused ? "paused" : "live");
  }

  #happened(event) {
    if (event.type === "placed") this.made.set(event.ball & 0xffff, made(event));
    if (event.type === "accepted") this.made.set(event.ball & 0xffff, this.#droppedBall());
    if (event.type === "removed") for (const ball of event.balls) this.#forget(ball);
    if (event.type === "landed") this.#forget(event.ball);
    if (event.type === "edited") this.#edited(event);
    if (event.type === "settings") this.#setSettings(event);
    this.listener.onEvent(event);
    this.listener.onChange();
  }

  #droppedBall() {
    return made(this.hello.board.ball);
  }

  #forget(ball) {
    if (this.#drag?.ball === ball) {
      clearTimeout(this.#drag.timer);
      clearTimeout(this.#drag.again);
      this.#drag = null;
    }
    this.made.delete(ball & 0xffff);
  }

  #edited(event) {
    const changed = ["radius", "density", "restitution", "friction"].filter((name) => name in event);
    const balls = event.ball === null ? this.made.values() : [this.made.get(event.ball & 0xffff)];
    for (const ball of balls) for (const name of changed) if (ball) ball[name] = event[name];
  }

  #snapshot(bytes) {
    if (!this.hello) return;
    const now = performance.now();
    const snapshot = decodeSnapshot(bytes, this.scale);
    const last = this.#snapshots.at(-1);
    if (last && snapshot.tick === last.tick) this.#snapshots.pop();
    // A room that slept, or a clock that stood, goes on with another offset.
    if (last && now - this.#quiet > 400) this.clock.restart();
    this.clock.observe(snapshot.tick, now);
    this.#snapshots.push(snapshot);
    if (this.#snapshots.length > KEPT) this.#snapshots.shift();
    this.#quiet = now;
    const resting = snapshot.asleep.every((one) => one === 1);
    this.#setState(this.paused ? "paused" : resting ? "asleep" : "live");
    this.listener.onChange();
  }

  #setState(state, detail) {
    if (state === this.#state && detail === undefined) return;
    this.#state = state;
    this.listener.onState(state, detail);
  }
}

function knot() {
  return { t: 0, x: 0, y: 0, angle: 0, vx: 0, vy: 0, vIn: true, vOut: true, bounced: false };
}

function fill(one, snapshot, i, rate) {
  one.t = snapshot.tick / rate;
  one.x = snapshot.x[i];
  one.y = snapshot.y[i];
  one.angle = snapshot.angle[i];
  one.vx = snapshot.vx[i];
  one.vy = snapshot.vy[i];
  one.bounced = snapshot.bounced[i] === 1;
  return one;
}

function made({ radius, density, restitution, friction }) {
  return { radius, density, restitution, friction };
}

/** Whether a value lies between two others, or near them. */
function inside(value, one, other) {
  const slack = 0.02 + 0.5 * Math.abs(one - other);
  return value >= Math.min(one, other) - slack && value <= Math.max(one, other) + slack;
}
