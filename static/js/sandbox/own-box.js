// A private box, which this page computes with the engine's kernels, without a server. It has the interface of a
// room, and records its inputs, so that a room on the server can continue it.

import { GRAVITY, RESTITUTION } from "../model/worlds.js";
import { getJson, messageOf } from "../net/api.js";
import { isTooMuch, isWithin, MOST_BALLS, MOST_OVERLAPS, SCENES, sceneOf } from "../solver/touching/values.js";
import { TICK_RATE, World } from "../solver/touching/world.js";
import { t } from "../texts/text.js";

/** @import { BallKind } from "../model/board.js" */
/** @import { SceneForm, Settings } from "../model/messages.js" */
/** @import { Machine } from "../solver/machine.js" */
/** @import { GaltonBoard, Scene } from "../solver/touching/scenes.js" */
/** @import { Configure, Edit, Input, Story } from "../solver/touching/world.js" */
/** @import { BoxHello, SandboxListener, Seen } from "./room.js" */

/** Balls that fall softly into a heap. @type {Scene} */
const OPENING = { ...SCENES.sandbox, gravity: GRAVITY.Moon, speed: 2 };

const MOST_TICKS = 30; // computed for one frame: after a long pause the box does not catch up
const MEASURED_TICKS = 6; // between two measurements
const INPUTS = ["clear", "remove", "step", "kick"]; // messages that the world takes as they are
const SETTLING_MS = 600; // for which frames are drawn after the last change

/** @type {Record<string, Record<string, number>>} */
const PRESETS = {
  gravity: { ...GRAVITY, none: 0 },
  restitution: Object.fromEntries(
    Object.entries(RESTITUTION).map(([name, [low, high]]) => [name, 0.5 * (low + high)])),
};

/** A message from the page's controls. @typedef {{type: string} & Record<string, any>} Message */

/** The private box; `begin` announces its first state. */
export class OwnBox {
  #measured = 0;
  #watching = true;
  #changed = 0;
  /** Local time of the last tick, ms; 0 while nothing moves. */
  #clock = 0;
  #asleep = false;
  /** @type {number | null} the ball that the player drags */
  #grabbed = null;
  /** @type {Map<number, [number, number, number]>} x, y and angle of each ball at the previous tick */
  #before = new Map();

  /** @param {Machine} machine @param {SandboxListener} listener */
  constructor(machine, listener) {
    this.machine = machine;
    this.listener = listener;
    this.world = new World(machine, OPENING, null);
  }

  get paused() {
    return this.world.paused;
  }

  /** Radius and material of each ball. @returns {Map<number, BallKind>} */
  get made() {
    const { table } = this.world.arena;
    return new Map(Array.from({ length: table.n }, (_, row) => [table.id(row), table.kind(row)]));
  }

  /** @returns {Settings} */
  get settings() {
    return this.world.settings;
  }

  /** The scene and all inputs, from which a server can continue. @returns {Story} */
  get story() {
    return this.world.story;
  }

  /** Whether the picture changes without further input. */
  get busy() {
    return this.world.runs || performance.now() - this.#changed < SETTLING_MS;
  }

  /** Switches measurements on or off. @param {boolean} wanted */
  watch(wanted) {
    this.#watching = wanted;
  }

  /** @param {number} ball @param {number} x @param {number} y */
  drag(ball, x, y) {
    if (this.#grabbed !== null && this.#grabbed !== ball) this.letGo();
    if (!this.world.has(ball)) return;
    this.#grabbed = ball;
    const [x0, x1, y0, y1] = this.world.arena.extent;
    const [atX, atY] = [clamped(x, x0, x1), clamped(y, y0 - 2, y1)];
    this.#carryOut({ type: "drag", ball, x: atX, y: atY });
  }

  letGo() {
    if (this.#grabbed === null) return;
    const ball = this.#grabbed;
    this.#grabbed = null;
    if (this.world.has(ball)) this.#carryOut({ type: "release", ball });
  }

  /**
   * Carries out a message as a room would.
   * @param {object} message
   * @returns {boolean} always true: it has arrived
   */
  send(message) {
    const asked = /** @type {Message} */ (message);
    if ("ball" in asked && !this.world.has(asked.ball)) return true;
    if (asked.type === "add") this.#add(asked);
    else if (asked.type === "settings") this.#configure(asked);
    else if (asked.type === "edit") this.#edit(asked);
    else if (asked.type === "reset") void this.#reset(asked.scene);
    else if (asked.type === "pause") this.#pause(asked.paused);
    else if (INPUTS.includes(asked.type)) {
      const gone = asked.type === "clear" ? [...this.made.keys()] : asked.type === "remove" ? [asked.ball] : [];
      this.#carryOut(/** @type {Input} */ (asked));
      if (gone.length) this.#forget(gone);
    }
    return true;
  }

  /** Advances the box to a local time. @param {number} nowMs @returns {Seen[]} where the balls are */
  look(nowMs) {
    const part = this.#advance(nowMs);
    const { table } = this.world.arena;
    return Array.from({ length: table.n }, (_, row) => {
      const id = table.id(row);
      const [x, y, arc, radius] = table.pos.subarray(4 * row, 4 * row + 4);
      const angle = arc / radius;
      const [x0, y0, angle0] = this.#before.get(id) ?? [x, y, angle];
      return {
        id, radius, asleep: table.isAsleep(row) && !this.world.holds(id),
        x: x0 + part * (x - x0), y: y0 + part * (y - y0), angle: angle0 + part * (angle - angle0),
      };
    });
  }

  // Time.

  /** @param {number} nowMs @returns {number} the fraction of the current tick that has passed */
  #advance(nowMs) {
    if (!this.world.runs) {
      this.#clock = 0;
      this.#rest();
      return 1;
    }
    if (!this.#clock) this.#clock = nowMs;
    const tickMs = 1000 / TICK_RATE;
    let ticks = 0;
    while (this.#clock + tickMs <= nowMs && this.world.runs) {
      this.#clock += tickMs;
      if (ticks < MOST_TICKS) this.#tick();
      ticks += 1;
    }
    if (ticks) this.#measure();
    return clamped((nowMs - this.#clock) / tickMs, 0, 1);
  }

  #tick() {
    const { table } = this.world.arena;
    this.#before.clear();
    for (let row = 0; row < table.n; row += 1) {
      const [x, y, arc, radius] = table.pos.subarray(4 * row, 4 * row + 4);
      this.#before.set(table.id(row), [x, y, arc / radius]);
    }
    const gone = this.world.step();
    if (gone.length) this.#forget(gone);
    if (this.#asleep) this.#wake();
  }

  #rest() {
    if (this.#asleep || this.paused) return;
    this.#asleep = true;
    this.#measured = 0;
    this.#measure();
    this.listener.onState("asleep");
  }

  #wake() {
    this.#asleep = false;
    this.listener.onState(this.paused ? "paused" : "live");
  }

  #measure() {
    const { tick, arena } = this.world;
    if (!this.#watching || (this.#measured && tick - this.#measured < MEASURED_TICKS)) return;
    this.#measured = tick;
    this.listener.onEvent({ type: "diagnostics", ...arena.diagnostics() });
  }

  // Inputs.

  /** @param {Input} input @returns {number} the ball, if the input added one */
  #carryOut(input) {
    this.#changed = performance.now();
    const ball = this.world.carryOut(input);
    if (this.#asleep && this.world.runs) this.#wake();
    this.listener.onChange();
    return ball;
  }

  /** @param {Message} asked */
  #add({ x, y, vx, vy, radius }) {
    const { arena, madeOf } = this.world;
    const { dt, substeps } = arena.settings;
    const count = arena.count + 1;
    const isCrowd = this.#overlaps(x, y, radius) > MOST_OVERLAPS;
    if (isCrowd || count > MOST_BALLS || isTooMuch(count, dt, substeps, TICK_RATE)) {
      this.listener.onError(t("box.full", { n: arena.count }));
      return;
    }
    const made = { radius, ...madeOf };
    const ball = this.#carryOut({ type: "add", x, y, vx, vy, ...made });
    this.listener.onEvent({ type: "placed", ball, ...made });
  }

  /** @param {number} x @param {number} y @param {number} radius @returns {number} balls that a new one would overlap */
  #overlaps(x, y, radius) {
    const { pos, n } = this.world.arena.table;
    let found = 0;
    for (let at = 0; at < 4 * n; at += 4) {
      const [dx, dy, reach] = [pos[at] - x, pos[at + 1] - y, pos[at + 3] + radius];
      if (dx * dx + dy * dy < reach * reach) found += 1;
    }
    return found;
  }

  /** @param {Message} asked numbers, or names of presets */
  #configure({ type, ...asked }) {
    const values = Object.fromEntries(Object.entries(asked).map(([name, value]) =>
      [name, typeof value === "string" ? PRESETS[name][value] : value]));
    if (!Object.entries(values).every(([name, value]) => isWithin(name, value))) return;
    const { dt, substeps } = { ...this.world.arena.settings, ...values };
    if (isTooMuch(this.world.arena.count, dt, substeps, TICK_RATE)) {
      this.listener.onError(t("box.too-fine"));
      return;
    }
    this.#carryOut(/** @type {Configure} */ ({ type, ...values }));
    this.listener.onEvent({ type: "edited", ball: null });
    this.#sendSettings();
  }

  /** @param {Message} asked */
  #edit({ type, ball, ...values }) {
    if (!Object.entries(values).every(([name, value]) => isWithin(name, value))) return;
    this.#carryOut(/** @type {Edit} */ ({ type, ball, ...values }));
    this.listener.onEvent({ type: "edited", ball, ...values });
  }

  /** @param {boolean} paused */
  #pause(paused) {
    this.#carryOut({ type: "pause", paused });
    this.#asleep = false;
    this.listener.onState(paused ? "paused" : "live");
    this.#sendSettings();
  }

  /** @param {number[]} balls that were removed */
  #forget(balls) {
    if (this.#grabbed !== null && !this.world.has(this.#grabbed)) this.#grabbed = null;
    this.listener.onEvent({ type: "removed", balls });
  }

  #sendSettings() {
    this.listener.onEvent({ type: "settings", settings: this.settings, paused: this.paused });
  }

  /** Restarts the box, with another scene if given. @param {SceneForm} [form] */
  async #reset(form) {
    try {
      const scene = form ? sceneOf(form) : this.world.scene;
      const board = scene.scene === "galton"
        ? /** @type {GaltonBoard} */ (await getJson("boards/galton")) : null;
      this.world = new World(this.machine, scene, board);
      this.begin();
    } catch (error) {
      this.listener.onError(messageOf(error));
    }
  }

  /** Announces the box's first state. */
  begin() {
    this.#clock = 0;
    this.#measured = 0;
    this.#grabbed = null;
    this.#asleep = false;
    this.#before.clear();
    this.#changed = performance.now();
    this.listener.onRoom(this.#hello());
    this.listener.onState(this.paused ? "paused" : "live");
  }

  /** @returns {BoxHello} */
  #hello() {
    const { arena, scene } = this.world;
    const [x_min, x_max, y_min, y_max] = arena.extent;
    return {
      room: "", board: null, board_name: "", extent: { x_min, x_max, y_min, y_max },
      limits: { balls: MOST_BALLS },
      arena: {
        scene, place: arena.place, settings: this.settings, paused: this.paused, owned: false,
        presets: PRESETS,
      },
    };
  }
}

/** @param {number} value @param {number} low @param {number} high */
function clamped(value, low, high) {
  return Math.max(low, Math.min(high, value));
}
