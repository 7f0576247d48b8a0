// The time of a replay: play, pause, scrub, slow motion, steps by frame or by impact, by buttons and keys.

import { t as words } from "../texts/text.js";
import { byId, isWithin, onChoice, onClick, radioValue } from "../util/dom.js";
import { fixed } from "../util/format.js";

const FRAME = 1 / 60; // s; a step is one frame at the chosen speed

/**
 * @typedef {object} Timeline
 * @property {number} duration s
 * @property {number} end s, when the lights after the landing have faded
 * @property {number[]} stops times to step to, s, ascending
 */

/** Runs the time `t` over a timeline; `onChange()` is called when a frame must be drawn, which `show` ends. */
export class Transport {
  /** The shown time, s. */
  t = 0;
  playing = false;
  speed = 1;
  #lastMs = 0;

  /** @param {Timeline} timeline @param {() => void} onChange */
  constructor(timeline, onChange) {
    this.timeline = timeline;
    this.onChange = onChange;
    this.button = byId("play", HTMLButtonElement);
    this.slider = byId("time", HTMLInputElement);
    this.clock = byId("clock");
    this.slider.max = String(timeline.duration);
    const follow = () => { this.speed = Number(radioValue("speed")); };
    follow();
    onChoice("speed", follow);
    this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
    onClick("play", () => this.#toggle());
    onClick("frame-back", () => this.#stepFrame(-1));
    onClick("frame-on", () => this.#stepFrame(1));
    onClick("impact-back", () => this.#stepStop(-1));
    onClick("impact-on", () => this.#stepStop(1));
    document.addEventListener("keydown", (event) => this.#key(event));
    this.seek(0);
  }

  #toggle() {
    if (this.t >= this.timeline.duration && !this.playing) this.t = 0;
    this.playing = !this.playing;
    this.#lastMs = 0;
    this.#change();
  }

  /** Begins when the page opens: plays, or with reduced motion shows the end. */
  begin() {
    if (window.matchMedia("(prefers-reduced-motion: reduce)").matches) this.seek(this.timeline.duration);
    else if (!this.playing) this.#toggle();
  }

  /** @param {number} t s */
  seek(t) {
    this.t = Math.min(Math.max(0, t), this.timeline.end);
    this.playing = false;
    this.#change();
  }

  #change() {
    this.show();
    this.onChange();
  }

  /** @param {1 | -1} way */
  #stepFrame(way) {
    this.seek(Math.min(this.t, this.timeline.duration) + way * FRAME * this.speed);
  }

  /** @param {1 | -1} way to the next or the previous stop */
  #stepStop(way) {
    const { stops } = this.timeline;
    const t = way > 0 ? stops.find((stop) => stop > this.t) : stops.findLast((stop) => stop < this.t);
    if (t !== undefined) this.seek(t);
  }

  /** @param {number} nowMs @returns {number} the time to draw, s */
  advance(nowMs) {
    if (!this.playing) return this.t;
    const elapsed = this.#lastMs ? (nowMs - this.#lastMs) / 1000 : 0;
    this.#lastMs = nowMs;
    const { duration, end } = this.timeline;
    // The bin's light fades in real time, however slow the fall was.
    this.t = Math.min(end, this.t + elapsed * (this.t < duration ? this.speed : 1));
    if (this.t >= end) this.playing = false;
    return this.t;
  }

  /** Shows the time, after everything that measures the page: text makes the browser lay it out again. */
  show() {
    const t = Math.min(this.t, this.timeline.duration);
    this.slider.value = String(t);
    const text = `${fixed(t, this.speed < 0.1 ? 4 : 3)} s`;
    this.slider.setAttribute("aria-valuetext", text);
    this.clock.textContent = text;
    const label = this.playing ? words("word.pause") : words("replay.play");
    if (this.button.textContent !== label) this.button.textContent = label;
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (isWithin(event, "input, select, textarea, [role=region]")) return;
    if (event.key === " " && isWithin(event, "button, a, summary")) return;
    /** @type {Record<string, () => void>} */
    const actions = {
      " ": () => !event.repeat && this.#toggle(),
      ArrowLeft: () => (event.shiftKey ? this.#stepStop(-1) : this.#stepFrame(-1)),
      ArrowRight: () => (event.shiftKey ? this.#stepStop(1) : this.#stepFrame(1)),
      Home: () => this.seek(0),
      End: () => this.seek(this.timeline.duration),
    };
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }
}
