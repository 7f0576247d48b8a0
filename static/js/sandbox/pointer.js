// The hand in the box: pointer and keys on the canvas become throws, drags and kicks.

const THROW_RATE = 5; // m/s for each metre that a sling is drawn
const FASTEST = 30; // m/s
const TAP_PX = 7;
const REACH_PX = 14; // a finger may miss a small ball by this much
const STEP = 0.1; // m that an arrow key moves the aim
const LONG_STEP = 0.5;

/**
 * @typedef {object} HandListener
 * @property {(ball: number, place: {x: number, y: number}) => void} onDrag
 * @property {() => void} onLetGo
 * @property {(ball: number) => void} onChoose
 * @property {(place: {x: number, y: number}, vx: number, vy: number) => void} onThrow
 * @property {() => void} onThrowAimed the keyboard's throw, as the sliders say
 * @property {() => void} onKick
 * @property {() => void} onRemove
 * @property {() => void} onPause
 * @property {() => void} onStep
 * @property {(text: string) => void} onSay
 * @property {() => void} onChange
 */

/** Follows pointer and keys over one view. */
export class SandboxHand {
  cross = { x: 0, y: 0 };
  crossShown = false;
  sling = null;
  chosen = null;
  locked = true;
  #pointer = null;
  #grabbed = null;

  /**
   * @param {import("./view.js").SandboxView} view
   * @param {(place: {x: number, y: number}, reach: number) => number | null} find the ball there
   * @param {() => number} radius of the next ball
   * @param {HandListener} listener
   */
  constructor(view, find, radius, listener) {
    Object.assign(this, { view, find, radius, listener });
    const canvas = view.moving;
    canvas.addEventListener("pointerdown", (event) => this.#down(event));
    canvas.addEventListener("pointermove", (event) => this.#move(event));
    canvas.addEventListener("pointerup", (event) => this.#up(event));
    canvas.addEventListener("pointercancel", () => this.#cancel());
    canvas.addEventListener("keydown", (event) => this.#key(event));
    canvas.addEventListener("focus", () => this.#showCross(canvas.matches(":focus-visible")));
    canvas.addEventListener("blur", () => this.#showCross(false));
  }

  /** A new room: aim at its upper middle, hold nothing. */
  begin({ x_min: x0, x_max: x1, y_min: y0, y_max: y1 }) {
    this.cross = { x: (x0 + x1) / 2, y: y0 + 0.3 * (y1 - y0) };
    this.chosen = null;
    this.#grabbed = null;
    this.#pointer = null;
    this.sling = null;
  }

  /** The ball is no more. */
  forget(ball) {
    if (this.chosen === ball) this.chosen = null;
    if (this.#grabbed === ball) this.#grabbed = null;
  }

  #down(event) {
    if (this.locked || this.#pointer !== null || event.button !== 0) return;
    this.#showCross(false);
    const place = this.view.placeOf(event);
    this.#pointer = event.pointerId;
    this.view.moving.setPointerCapture(event.pointerId);
    this.ball = this.find(place, REACH_PX / this.view.scale);
    if (this.ball !== null) {
      this.#choose(this.ball);
      this.listener.onDrag(this.ball, place);
    } else {
      const { x, y } = this.#within(place);
      this.sling = { x, y, toX: x, toY: y, radius: this.radius() };
    }
    this.listener.onChange();
  }

  #move(event) {
    if (event.pointerId !== this.#pointer) return;
    const place = this.view.placeOf(event);
    if (this.ball !== null) this.listener.onDrag(this.ball, place);
    else Object.assign(this.sling, { toX: place.x, toY: place.y });
    this.listener.onChange();
  }

  #up(event) {
    if (event.pointerId !== this.#pointer) return;
    const { ball, sling } = this;
    this.#cancel();
    if (ball !== null || !sling) return;
    const [dx, dy] = [sling.toX - sling.x, sling.toY - sling.y];
    const tap = Math.hypot(dx, dy) * this.view.scale < TAP_PX;
    const speed = tap ? 0 : Math.min(FASTEST, THROW_RATE * Math.hypot(dx, dy));
    const way = Math.hypot(dx, dy) || 1;
    this.listener.onThrow({ x: sling.x, y: sling.y }, (speed * dx) / way, (speed * dy) / way);
  }

  #cancel() {
    if (this.ball !== null && this.#pointer !== null) this.listener.onLetGo();
    this.#pointer = null;
    this.ball = null;
    this.sling = null;
    this.listener.onChange();
  }

  /** A place where a ball of the next throw fits between the walls. */
  #within({ x, y }) {
    const { x_min: x0, x_max: x1, y_min: y0, y_max: y1 } = this.view.extent;
    const margin = this.radius() + 0.001;
    const clamp = (value, low, high) => Math.max(low + margin, Math.min(high - margin, value));
    return { x: clamp(x, x0, x1), y: clamp(y, y0, y1) };
  }

  #choose(ball) {
    this.chosen = ball;
    this.listener.onChoose(ball);
  }

  #showCross(shown) {
    this.crossShown = shown && !this.locked;
    this.listener.onChange();
  }

  #key(event) {
    if (this.locked || event.ctrlKey || event.altKey || event.metaKey) return;
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    const act = {
      Enter: () => this.listener.onThrowAimed(),
      g: () => this.#grab(),
      k: () => this.listener.onKick(),
      Delete: () => this.listener.onRemove(),
      Backspace: () => this.listener.onRemove(),
    }[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!way && !act) return;
    event.preventDefault();
    this.#showCross(true);
    if (act) {
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
      this.listener.onSay("Let go.");
      return;
    }
    const ball = this.find(this.cross, Number.POSITIVE_INFINITY);
    if (ball === null) {
      this.listener.onSay("There is no ball to grab.");
      return;
    }
    this.#grabbed = ball;
    this.#choose(ball);
    this.listener.onDrag(ball, this.cross);
    this.listener.onSay(`Ball ${ball} is held; arrow keys move it, G lets go.`);
  }
}
