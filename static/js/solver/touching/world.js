// A scene of touching balls with its clock, its grabbed balls, and the record of all inputs.
//
// The same inputs at the same ticks give the same world in app/rooms/touching, bit for bit. So a server
// can continue a page's world from its `story`.

import { PHYSICS_VERSION } from "../digest.js";
import { Arena, SETTINGS } from "./arena.js";
import { openingOf } from "./scenes.js";
import { SINCE_2 } from "./values.js";

/** @import { ArenaSettings } from "./arena.js" */
/** @import { Machine } from "../machine.js" */
/** @import { GaltonBoard, Scene } from "./scenes.js" */

export const TICK_RATE = 60; // ticks a second
const HOLD_RATE = 12; // 1/s; a grabbed ball moves toward the hand at this rate times their distance
const HOLD_SPEED = 15; // m/s, the highest speed of a grabbed ball
const HOLD_TICKS = 5 * TICK_RATE; // a hand that sends nothing for this long releases its ball

/** @type {("density" | "restitution" | "friction")[]} */
const OF_BALLS = ["density", "restitution", "friction"];

/** @typedef {Record<"density" | "restitution" | "friction", number>} Material of a ball; density in kg/m² */

/**
 * Inputs of a world, in the form of a room's log. SI units; an omitted field changes nothing.
 * @typedef {{type: "add", x: number, y: number, vx?: number, vy?: number, radius: number} & Material} Add
 * @typedef {{type: "kick", ball: number, vx?: number, vy?: number, omega?: number}} Kick
 * @typedef {{type: "drag", ball: number, x: number, y: number}} Drag
 * @typedef {{type: "release" | "remove", ball: number}} OfBall
 * @typedef {{type: "edit", ball: number, radius?: number} & Partial<Material>} Edit
 * @typedef {{type: "settings"} & Partial<ArenaSettings & Material>} Configure
 * @typedef {{type: "pause", paused: boolean}} Pause
 * @typedef {{type: "clear" | "step"}} Plain
 * @typedef {Add | Kick | Drag | OfBall | Edit | Configure | Pause | Plain} Input
 */

/**
 * @typedef {{scene: Scene, tick_rate: number, physics_version: number, tick: number,
 *   inputs: {tick: number, input: Input}[]}} Story
 */

/** A running scene. */
export class World {
  tick = 0;
  paused = false;
  /** All inputs until now. @type {{tick: number, input: Input}[]} */
  inputs = [];
  /** Single steps that are still to run while paused. */
  #steps = 0;
  /** By ball: the place of the hand, m, and the tick at which it releases the ball. @type {Map<number, {x: number, y: number, lapse: number}>} */
  #holds = new Map();

  /**
   * @param {Machine} machine @param {Scene} scene
   * @param {GaltonBoard | null} board the preset `galton`, for the scene `galton`
   */
  constructor(machine, scene, board) {
    this.scene = scene;
    const { place, balls } = openingOf(scene, board);
    const settings = /** @type {ArenaSettings} */ ({ ...SINCE_2, ...picked(scene, SETTINGS) });
    this.arena = new Arena(machine, place, settings);
    this.arena.add(balls);
    const { density, restitution, friction } = scene;
    /** The default material of new balls. @type {Material} */
    this.madeOf = { density, restitution, friction };
  }

  /** The arena's settings, and the default material of new balls. */
  get settings() {
    return { ...this.arena.settings, ...this.madeOf };
  }

  /** Whether the next tick changes anything. */
  get runs() {
    if (this.paused) return this.#steps > 0;
    return this.#holds.size > 0 || this.arena.awake;
  }

  /** All that a server needs to continue this world. @returns {Story} */
  get story() {
    const { scene, tick, inputs } = this;
    return { scene, tick_rate: TICK_RATE, physics_version: PHYSICS_VERSION, tick, inputs };
  }

  /** @param {number} ball */
  has(ball) {
    return this.arena.table.row(ball) >= 0;
  }

  /** Whether a hand holds the ball. @param {number} ball */
  holds(ball) {
    return this.#holds.has(ball);
  }

  /**
   * Carries out an input and records it.
   * @param {Input} input already checked: valid values, and a ball that exists
   * @returns {number} the id of a new ball, or -1
   */
  carryOut(input) {
    this.#keep(input);
    const { arena } = this;
    switch (input.type) {
      case "add": {
        const { x, y, vx, vy, radius, density, restitution, friction } = input;
        return arena.add([{ x, y, vx: vx ?? 0, vy: vy ?? 0, radius, density, restitution, friction }]);
      }
      case "kick":
        arena.table.kick(arena.table.row(input.ball), input.vx ?? 0, input.vy ?? 0, input.omega ?? 0);
        break;
      case "drag":
        this.#holds.set(input.ball, { x: input.x, y: input.y, lapse: this.tick + HOLD_TICKS });
        break;
      case "release":
        this.#holds.delete(input.ball);
        break;
      case "remove":
        this.#holds.delete(input.ball);
        arena.remove(input.ball);
        break;
      case "clear":
        this.#holds.clear();
        arena.clear();
        break;
      case "edit":
        arena.table.edit([arena.table.row(input.ball)], input);
        break;
      case "settings":
        this.#configure(input);
        break;
      case "pause":
        this.paused = input.paused;
        this.#steps = 0;
        break;
      case "step":
        if (this.paused) this.#steps += 1;
    }
    return -1;
  }

  /** Records an input. Of several moves of a hand in one tick only the last counts. @param {Input} input */
  #keep(input) {
    const last = this.inputs.at(-1);
    if (input.type === "drag" && last?.tick === this.tick && last.input.type === "drag") {
      if (last.input.ball === input.ball) this.inputs.pop();
    }
    this.inputs.push({ tick: this.tick, input });
  }

  /** @param {Configure} input */
  #configure(input) {
    const ofBalls = picked(input, OF_BALLS);
    const ofAll = picked(input, SETTINGS);
    if (Object.keys(ofBalls).length) {
      Object.assign(this.madeOf, ofBalls);
      this.arena.table.edit(Array.from({ length: this.arena.count }, (_, row) => row), ofBalls);
      if (ofBalls.friction !== undefined) this.arena.editPlace(ofBalls.friction);
    }
    if (Object.keys(ofAll).length) this.arena.configure(ofAll);
  }

  /** Advances by one tick. @returns {number[]} balls that were removed, as they left the arena */
  step() {
    this.#pull();
    const gone = this.arena.advance(1 / TICK_RATE);
    this.tick += 1;
    if (this.#steps) this.#steps -= 1;
    return gone;
  }

  #pull() {
    const { table } = this.arena;
    for (const [ball, { x, y, lapse }] of [...this.#holds].sort(([a], [b]) => a - b)) {
      const row = table.row(ball);
      if (row < 0 || this.tick >= lapse) {
        this.#holds.delete(ball);
        continue;
      }
      let vx = HOLD_RATE * (x - table.pos[4 * row]);
      let vy = HOLD_RATE * (y - table.pos[4 * row + 1]);
      const speed = Math.sqrt(vx * vx + vy * vy);
      if (speed > HOLD_SPEED) {
        vx *= HOLD_SPEED / speed;
        vy *= HOLD_SPEED / speed;
      }
      table.kick(row, vx - table.vel[4 * row], vy - table.vel[4 * row + 1], 0);
    }
  }
}

/**
 * @template {string} K
 * @param {Partial<Record<K, number>>} values @param {K[]} names
 * @returns {Partial<Record<K, number>>} only the given ones
 */
function picked(values, names) {
  return /** @type {Partial<Record<K, number>>} */ (
    Object.fromEntries(names.filter((name) => values[name] !== undefined).map((name) => [name, values[name]])));
}
