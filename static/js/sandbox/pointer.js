// Turns pointer and keys on the canvas into throws, drags and kicks.

import { t } from "../texts/text.js";

/** @import { SandboxView } from "./view.js" */
/** @import { Point } from "../model/board.js" */
/** @import { Extent } from "../model/messages.js" */

const THROW_RATE = 5; // m/s for each metre that the sling is drawn
const FASTEST = 30; // m/s
const TAP_PX = 7;
const REACH_PX = 14; // by which a finger may miss a small ball
const STEP = 0.1; // m that an arrow key moves the aim
const LONG_STEP = 0.5;

/** @type {Record<string, [number, number] | undefined>} */
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/**
 * @typedef {{x: number, y: number, toX: number, toY: number, radius: number}} Sling m
 *
 * @typedef {object} PointerListener
 * @property {(ball: number, place: Point) => void} onDrag
 * @property {() => void} onLetGo
 * @property {(ball: number) => void} onChoose
 * @property {(place: Point, vx: number, vy: number) => void} onThrow
 * @property {() => void} onThrowAimed throw from the cross, with the sliders' speed and angle
 * @property {() => void} onKick
 * @property {() => void} onRemove
 * @property {(text: string) => void} onSay
 * @property {() => void} onChange
 */

/** Listens to one view's canvas. */
export class PointerController {
  cross = { x: 0, y: 0 };
  crossShown = false;
  /** @type {Sling | null} */
  sling = null;
  /** @type {number | null} the selected ball */
  chosen = null;
  locked = true;
  /** @type {number | null} ID of the pressed pointer */
  #pointer = null;
  /** @type {number | null} the ball that it drags */
  #dragged = null;
  /** @type {number | null} the ball that the keyboard drags */
  #grabbed = null;

  /**
   * @param {SandboxView} view
   * @param {(place: Point, reach: number) => number | null} find returns the ball at a point
   * @param {() => number} radius of the next ball
   * @param {PointerListener} listener
   */
  constructor(view, find, radius, listener) {
    this.view = view;
    this.find = find;
    this.radius = radius;
    this.listener = listener;
    const canvas = view.moving;
    canvas.addEventListener("pointerdown", (event) => this.#down(event));
    canvas.addEventListener("pointermove", (event) => this.#move(event));
    canvas.addEventListener("pointerup", (event) => this.#up(event));
    canvas.addEventListener("pointercancel", () => this.#cancel());
    canvas.addEventListener("keydown", (event) => this.#key(event));
    canvas.addEventListener("focus", () => this.#showCross(canvas.matches(":focus-visible")));
    canvas.addEventListener("blur", () => this.#showCross(false));
  }

  /** Whether the player holds a ball, by pointer or keyboard. */
  get holds() {
    return this.#dragged !== null || this.#grabbed !== null;
  }

  /** A new room: aims at its upper middle, with no ball grabbed. @param {Extent} extent */
  begin({ x_min: x0, x_max: x1, y_min: y0, y_max: y1 }) {
    this.cross = { x: (x0 + x1) / 2, y: y0 + 0.3 * (y1 - y0) };
    this.chosen = null;
    this.#grabbed = null;
    this.#pointer = null;
    this.sling = null;
  }

  /** The ball was removed. @param {number} ball */
  forget(ball) {
    if (this.chosen === ball) this.chosen = null;
    if (this.#grabbed === ball) this.#grabbed = null;
  }

  /** @param {PointerEvent} event */
  #down(event) {
    if (this.locked || this.#pointer !== null || event.button !== 0) return;
    this.#showCross(false);
    const place = this.view.placeOf(event);
    this.#pointer = event.pointerId;
    this.view.moving.setPointerCapture(event.pointerId);
    this.#dragged = this.find(place, REACH_PX / this.view.scale);
    if (this.#dragged !== null) {
      this.#choose(this.#dragged);
      this.listener.onDrag(this.#dragged, place);
    } else {
      const { x, y } = this.#within(place);
      this.sling = { x, y, toX: x, toY: y, radius: this.radius() };
    }
    this.listener.onChange();
  }

  /** @param {PointerEvent} event */
  #move(event) {
    if (event.pointerId !== this.#pointer) return;
    const place = this.view.placeOf(event);
    if (this.#dragged !== null) this.listener.onDrag(this.#dragged, place);
    else if (this.sling) Object.assign(this.sling, { toX: place.x, toY: place.y });
    this.listener.onChange();
  }

  /** @param {PointerEvent} event */
  #up(event) {
    if (event.pointerId !== this.#pointer) return;
    const { sling } = this;
    const ball = this.#dragged;
    this.#cancel();
    if (ball !== null || !sling) return;
    const [dx, dy] = [sling.toX - sling.x, sling.toY - sling.y];
    const tap = Math.hypot(dx, dy) * this.view.scale < TAP_PX;
    const speed = tap ? 0 : Math.min(FASTEST, THROW_RATE * Math.hypot(dx, dy));
    const way = Math.hypot(dx, dy) || 1;
    this.listener.onThrow({ x: sling.x, y: sling.y }, (speed * dx) / way, (speed * dy) / way);
  }

  #cancel() {
    if (this.#dragged !== null && this.#pointer !== null) this.listener.onLetGo();
    this.#pointer = null;
    this.#dragged = null;
    this.sling = null;
    this.listener.onChange();
  }

  /** The nearest point where the next ball fits between the walls. @param {Point} point */
  #within({ x, y }) {
    const { x_min: x0, x_max: x1, y_min: y0, y_max: y1 } = this.view.extent;
    const margin = this.radius() + 0.001;
    /** @param {number} value @param {number} low @param {number} high */
    const clamp = (value, low, high) => Math.max(low + margin, Math.min(high - margin, value));
    return { x: clamp(x, x0, x1), y: clamp(y, y0, y1) };
  }

  /** @param {number} ball */
  #choose(ball) {
    this.chosen = ball;
    this.listener.onChoose(ball);
  }

  /** @param {boolean} shown */
  #showCross(shown) {
    this.crossShown = shown && !this.locked;
    this.listener.onChange();
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (this.locked || event.ctrlKey || event.altKey || event.metaKey) return;
    const way = ARROWS[event.key];
    /** @type {Record<string, () => void>} */
    const acts = {
      Enter: () => this.listener.onThrowAimed(),
      g: () => this.#grab(),
      k: () => this.listener.onKick(),
      Delete: () => this.listener.onRemove(),
      Backspace: () => this.listener.onRemove(),
    };
    const act = acts[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!way && !act) return;
    event.preventDefault();
    this.#showCross(true);
    if (!way) {
      if (!event.repeat) act();
      return;
    }
    const step = event.shiftKey ? LONG_STEP : STEP;
    this.cross = this.#within({ x: this.cross.x + step * way[0], y: this.cross.y + step * way[1] });
    if (this.#grabbed !== null) this.listener.onDrag(this.#grabbed, this.cross);
    this.listener.onChange();
  }

  #grab() {
    if (this.#grabbed !== null) {
      this.#grabbed = null;
      this.listener.onLetGo();
      this.listener.onSay(t("box.let-go"));
      return;
    }
    const ball = this.find(this.cross, Number.POSITIVE_INFINITY);
    if (ball === null) {
      this.listener.onSay(t("box.no-ball"));
      return;
    }
    this.#grabbed = ball;
    this.#choose(ball);
    this.listener.onDrag(ball, this.cross);
    this.listener.onSay(t("box.held", { ball }));
  }
}
