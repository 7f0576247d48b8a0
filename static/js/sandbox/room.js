// A live room of touching balls: receives its state and snapshots, interpolates positions, and sends the inputs.

import { poseBetween, shortestTurn } from "../model/motion/interpolate.js";
import { socketUrl } from "../net/api.js";
import { Connection, ROOM_MOVED } from "../net/connection.js";
import { decodeEvents, decodeSnapshot } from "../net/protocol.js";
import { TickClock } from "../net/tick-clock.js";
import { t } from "../texts/text.js";

/** @import { BallKind } from "../model/board.js" */
/**
 * @import { Arena, ArenaEvent, ArenaHello, ArenaMessage, Edited, Settings, Snapshot, SnapshotBall } from "../model/messages.js"
 */
/** @import { Keyframe, Law, Pose } from "../model/motion/interpolate.js" */
/** @import { SnapshotScale } from "../net/protocol.js" */

const KEPT = 24; // snapshots: more than the clock's longest delay needs
const DRAG_MS = 33; // between two sent positions of the pointer
const HOLD_MS = 1000; // between repeats while the pointer rests: without them the server ends the drag

/** @typedef {"connecting" | "live" | "asleep" | "paused" | "reconnecting" | "closed"} RoomState */

/**
 * The first state of a room or private box.
 * @typedef {Pick<ArenaHello, "room" | "board" | "board_name" | "extent" | "limits"> & {arena: Omit<Arena, "balls">}} BoxHello
 *
 * @typedef {object} SandboxListener
 * @property {(hello: BoxHello) => void} onRoom the room was entered, re-entered, or restarted
 * @property {(state: RoomState, detail?: string) => void} onState
 * @property {(event: ArenaEvent) => void} onEvent placed, edited, removed, settings, diagnostics, landed
 * @property {(message: string) => void} onError
 * @property {() => void} onChange there is something new to draw
 */

/** @typedef {{id: number, x: number, y: number, angle: number, radius: number, asleep: boolean}} Seen */

/** @typedef {{ball: number, x: number, y: number, sent: number, timer: number, again: number}} Drag */

/** One room, across reconnects. */
export class SandboxRoom {
  /** @type {ArenaHello | null} */
  hello = null;
  paused = false;
  /** @type {Settings} */
  settings = { gravity: 0, gravity_x: 0, drag: 0 };
  /** Radius and material of each ball. @type {Map<number, BallKind>} */
  made = new Map();
  #clock = new TickClock({ rate: 60 });
  /** @type {SnapshotScale} */
  #scale = { extent: { x_min: 0, x_max: 1, y_min: 0, y_max: 1 }, velocityScale: 1 };
  /** @type {Law} */
  #law = { gravity: 0, drag: 0 };
  /** @type {Snapshot[]} */
  #snapshots = [];
  /** @type {RoomState} */
  #state = "connecting";
  #watching = false;
  #quiet = 0;
  /** @type {Drag | null} */
  #drag = null;

  /** @param {string} room @param {SandboxListener} listener */
  constructor(room, listener) {
    this.room = room;
    this.listener = listener;
    this.connection = new Connection(socketUrl(room), {
      onText: (text) => {
        for (const event of /** @type {ArenaMessage[]} */ (decodeEvents(text))) this.#take(event);
      },
      onBytes: (bytes) => this.#takeSnapshot(bytes),
      onForeign: (reason) => this.#setState("closed", reason),
      onLost: (waitMs) => this.#setState("reconnecting", String(Math.max(1, Math.round(waitMs / 1000)))),
      onRefused: () => this.#setState("closed", t("box.no-room", { room })),
    });
  }

  /** @param {object} message @returns {boolean} false without a connection */
  send(message) {
    return this.hello !== null && this.connection.send(message);
  }

  /**
   * Subscribes to diagnostics, or unsubscribes: a hidden page needs none.
   * @param {boolean} wanted
   */
  watch(wanted) {
    this.#watching = wanted;
    this.send({ type: "watch", diagnostics: wanted });
  }

  /**
   * Drags a ball to a point. Messages are limited to one per DRAG_MS; the last position is always sent.
   * @param {number} ball
   * @param {number} x m
   * @param {number} y m
   */
   drag(ball, x, y) {
    if (this.#drag?.ball !== ball) this.letGo();
    const drag = (this.#drag ??= { ball, x, y, sent: 0, timer: 0, again: 0 });
    Object.assign(drag, { x, y });
    const wait = DRAG_MS - (performance.now() - drag.sent);
    if (wait <= 0) this.#sendDrag(drag);
    else drag.timer ||= setTimeout(() => this.#sendDrag(drag), wait);
  }

  /** Releases the dragged ball, which flies on. */
  letGo() {
    if (!this.#drag) return;
    const { ball, x, y, sent } = this.#drag;
    this.#endDrag();
    if (performance.now() - sent < 10 * DRAG_MS) this.send({ type: "drag", ball, x, y });
    this.send({ type: "release", ball });
  }

  #endDrag() {
    clearTimeout(this.#drag?.timer);
    clearTimeout(this.#drag?.again);
    this.#drag = null;
  }

  /** @param {Drag} drag */
  #sendDrag(drag) {
    drag.timer = 0;
    drag.sent = performance.now();
    this.send({ type: "drag", ball: drag.ball, x: drag.x, y: drag.y });
    clearTimeout(drag.again);
    drag.again = setTimeout(() => this.#drag === drag && this.#sendDrag(drag), HOLD_MS);
  }

  /** @param {number} nowMs local time @returns {Seen[]} where the balls are */
  look(nowMs) {
    const last = this.#snapshots.at(-1);
    if (!last) return [];
    const tick = this.#clock.renderTick(nowMs);
    let at = this.#snapshots.length - 1;
    while (at > 0 && this.#snapshots[at - 1].tick >= tick) at -= 1;
    const to = this.#snapshots[at];
    const from = at > 0 && tick < to.tick ? this.#snapshots[at - 1] : to;
    const before = new Map(from === to ? [] : from.balls.map((ball) => [ball.id, ball]));
    return to.balls.flatMap((ball) => {
      const { id, asleep } = ball;
      const [made, old] = [this.made.get(id), before.get(id)];
      const { x, y, angle } = old ? this.#between(from.tick, old, to.tick, ball, tick) : ball;
      return made ? [{ id, x, y, angle, radius: made.radius, asleep }] : [];
    });
  }

  /** Whether the picture changes without further input. */
  get busy() {
    return performance.now() - this.#quiet < 600;
  }

  /**
   * @param {number} from @param {SnapshotBall} a @param {number} to @param {SnapshotBall} b
   * @param {number} tick
   * @returns {Pose}
   */
  #between(from, a, to, b, tick) {
    if (a.x === b.x && a.y === b.y && a.angle === b.angle) return b;
    if (to - from <= 2) {
      const [one, other] = [keyframe(a, from / this.#clock.rate), keyframe(b, to / this.#clock.rate)];
      const pose = poseBetween(one, other, tick / this.#clock.rate, this.#law);
      // Balls in contact do not follow free flight: if it leaves the range between both, interpolate linearly.
      if (inside(pose.x, a.x, b.x) && inside(pose.y, a.y, b.y)) return pose;
    }
    const s = (tick - from) / (to - from);
    return {
      x: a.x + s * (b.x - a.x), y: a.y + s * (b.y - a.y), angle: a.angle + s * shortestTurn(a.angle, b.angle),
    };
  }

  /** @param {ArenaMessage} event */
  #take(event) {
    if (event.type === "hello") this.#greeted(event);
    else if (event.type === "error") {
      if (event.code !== ROOM_MOVED) this.listener.onError(event.detail);
    } else if (event.type === "halted") this.listener.onError(t(event.halted ? "box.halted" : "play.resumed"));
    else if (event.type === "notice") this.listener.onError(event.leaving ? t("play.leaving") : event.text ?? "");
    else this.#happened(event);
  }

  /** @param {ArenaHello} hello */
  #greeted(hello) {
    if (!hello.arena) {
      this.connection.close();
      this.#setState("closed", t("box.not-touching", { room: hello.room }));
      return;
    }
    this.connection.settled();
    this.hello = hello;
    this.#clock = new TickClock({ rate: hello.tick_rate });
    this.#snapshots = [];
    this.#drag = null;
    this.#scale = { extent: hello.extent, velocityScale: hello.velocity_scale };
    const { ball, radius, density, restitution, friction } = hello.arena.balls;
    this.made = new Map(ball.map((id, i) => [id & 0xffff, {
      radius: radius[i], density: density[i], restitution: restitution[i], friction: friction[i],
    }]));
    this.#setSettings(hello.arena);
    this.#quiet = performance.now();
    this.listener.onRoom(hello);
    if (this.#watching) this.watch(true);
  }

  /** @param {{settings: Settings, paused: boolean}} given */
  #setSettings({ settings, paused }) {
    this.settings = settings;
    this.paused = paused;
    this.#law = { gravity: settings.gravity, across: settings.gravity_x, drag: settings.drag };
    this.#setState(paused ? "paused" : "live");
  }

  /** @param {ArenaEvent} event */
  #happened(event) {
    if (event.type === "placed") this.made.set(event.ball & 0xffff, made(event));
    const dropped = this.hello?.board?.ball;
    if (event.type === "accepted" && dropped) this.made.set(event.ball & 0xffff, made(dropped));
    if (event.type === "removed") for (const ball of event.balls) this.#forget(ball);
    if (event.type === "landed") this.#forget(event.ball);
    if (event.type === "edited") this.#edited(event);
    if (event.type === "settings") this.#setSettings(event);
    this.listener.onEvent(event);
    this.listener.onChange();
  }

  /** @param {number} ball */
  #forget(ball) {
    if (this.#drag?.ball === ball) this.#endDrag();
    this.made.delete(ball & 0xffff);
  }

  /** @param {Edited} event */
  #edited(event) {
    const { ball: which, radius, density, restitution, friction } = event;
    const given = Object.entries({ radius, density, restitution, friction });
    const changed = Object.fromEntries(given.filter(([, value]) => value !== undefined));
    const balls = which === null ? this.made.values() : [this.made.get(which & 0xffff)];
    for (const ball of balls) if (ball) Object.assign(ball, changed);
  }

  /** @param {ArrayBuffer} bytes */
  #takeSnapshot(bytes) {
    if (!this.hello) return;
    const now = performance.now();
    const last = this.#snapshots.at(-1);
    const snapshot = decodeSnapshot(bytes, this.#scale, last?.tick ?? this.hello.tick);
    if (last && snapshot.tick === last.tick) this.#snapshots.pop();
    // After a pause of the room the offset between its ticks and local time has changed.
    if (last && now - this.#quiet > 400) this.#clock.restart();
    this.#clock.observe(snapshot.tick, now);
    this.#snapshots.push(snapshot);
    if (this.#snapshots.length > KEPT) this.#snapshots.shift();
    this.#quiet = now;
    const resting = snapshot.balls.every(({ asleep }) => asleep);
    this.#setState(this.paused ? "paused" : resting ? "asleep" : "live");
    this.listener.onChange();
  }

  /** @param {RoomState} state @param {string} [detail] */
  #setState(state, detail) {
    if (state === this.#state && detail === undefined) return;
    this.#state = state;
    this.listener.onState(state, detail);
  }
}

/** @param {SnapshotBall} ball @param {number} t s @returns {Keyframe} */
function keyframe({ x, y, angle, vx, vy, bounced }, t) {
  return { t, x, y, angle, vx, vy, bounced, vIn: true, vOut: true };
}

/** @param {BallKind} ballKind */
function made({ radius, density, restitution, friction }) {
  return { radius, density, restitution, friction };
}

/**
 * Whether a value lies between two others, or close to that range.
 * @param {number} value
 * @param {number} one
 * @param {number} other
 */
function inside(value, one, other) {
  const slack = 0.02 + 0.5 * Math.abs(one - other);
  return value >= Math.min(one, other) - slack && value <= Math.max(one, other) + slack;
}
