// Time of a replay: play, pause, scrub, step by frame or by impact, slow motion; buttons and keys.

import { byId } from "../util/dom.js";

const FRAME = 1 / 60; // s of a display's frame; a step is what plays in one at the chosen speed

/**
 * What is to be played.
 * @typedef {object} Score
 * @property {number} duration s
 * @property {number} end s, with what lights up after the landing
 * @property {number[]} stops ascending times to step to
 */

/** Runs the time `t` over a score; `onChange()` asks for the picture of a moment. */
export class Transport {
  /** Moment shown, s. */
  t = 0;
  playing = false;
  #lastMs = 0;
  /** @type {Score} */
  #score = { duration: 0, end: 0, stops: [] };

  /** @param {() => void} onChange */
  constructor(onChange) {
    this.onChange = onChange;
    this.button = byId("play");
    this.slider = byId("time");
    this.clock = byId("clock");
    this.button.addEventListener("click", () => this.toggle());
    this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
    byId("frame-back").addEventListener("click", () => this.stepFrame(-1));
    byId("frame-on").addEventListener("click", () => this.stepFrame(1));
    byId("impact-back").addEventListener("click", () => this.stepStop(-1));
    byId("impact-on").addEventListener("click", () => this.stepStop(1));
    document.addEventListener("keydown", (event) => this.#key(event));
  }

  /** @param {Score} score */
  load(score) {
    this.#score = score;
    this.slider.max = String(score.duration);
    this.seek(0);
  }

  get score() {
    return this.#score;
  }

  get speed() {
    return Number(document.querySelector("input[name=speed]:checked").value);
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  play() {
    if (this.t >= this.#score.duration) this.t = 0;
    this.playing = true;
    this.#lastMs = 0;
    this.#show();
  }

  pause() {
    this.playing = false;
    this.#show();
  }

  /** @param {number} t s */
  seek(t) {
    this.t = Math.min(Math.max(0, t), this.#score.end);
    this.playing = false;
    this.#show();
  }

  /** @param {1 | -1} way */
  stepFrame(way) {
    this.seek(Math.min(this.t, this.#score.duration) + way * FRAME * this.speed);
  }

  /** @param {1 | -1} way to the next or the last stop */
  stepStop(way) {
    const { stops } = this.#score;
    const t = way > 0 ? stops.find((stop) => stop > this.t) : stops.findLast((stop) => stop < this.t);
    if (t !== undefined) this.seek(t);
  }

  /** @param {number} nowMs @returns {number} the moment to draw, s */
  advance(nowMs) {
    if (!this.playing) return this.t;
    const elapsed = this.#lastMs ? (nowMs - this.#lastMs) / 1000 : 0;
    this.#lastMs = nowMs;
    const { duration, end } = this.#score;
    // The bin's light fades in real time, however slow the fall was.
    this.t = Math.min(end, this.t + elapsed * (this.t < duration ? this.speed : 1));
    if (this.t >= end) this.playing = false;
    this.#show(false);
    return this.t;
  }

  #show(wake = true) {
    const t = Math.min(this.t, this.#score.duration);
    this.slider.value = String(t);
    const text = `${t.toFixed(this.speed < 0.1 ? 4 : 3)} s`;
    this.slider.setAttribute("aria-valuetext", text);
    this.clock.textContent = text;
    const label = this.playing ? "Pause" : "Play";
    if (this.button.textContent !== label) this.button.textContent = label;
    if (wake) this.onChange();
  }

  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.target.closest("input, select, textarea, [role=region]")) return;
    if (event.key === " " && event.target.closest("button, a, summary")) return;
    const action = {
      " ": () => event.repeat || this.toggle(),
      ArrowLeft: () => (event.shiftKey ? this.stepStop(-1) : this.stepFrame(-1)),
      ArrowRight: () => (event.shiftKey ? this.stepStop(1) : this.stepFrame(1)),
      Home: () => this.seek(0),
      End: () => this.seek(this.#score.duration),
    }[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }
}
