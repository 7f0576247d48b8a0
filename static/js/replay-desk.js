// The replay's controls: play, pause, scrub, speed, and the facts of the drop.

import { byId, make } from "./dom.js";
import { multiplier, seconds } from "./format.js";

/** Runs a replay's time; `onTime(t)` asks for the picture of a moment. */
export class ReplayDesk {
  /** Moment of the replay, s. */
  t = 0;
  playing = false;
  #lastMs = 0;

  /**
   * @param {import("./replay.js").Replay} replay
   * @param {() => void} onChange the moment has changed, or time starts to run
   */
  constructor(replay, onChange) {
    this.replay = replay;
    this.onChange = onChange;
    this.button = byId("replay-play");
    this.slider = byId("replay-time");
    this.clock = byId("replay-clock");
    this.slider.max = String(replay.duration);
    this.button.addEventListener("click", () => this.toggle());
    this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
    document.addEventListener("keydown", (event) => this.#key(event));
    this.#fillFacts();
    this.seek(0);
  }

  get speed() {
    return Number(document.querySelector("input[name=speed]:checked").value);
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  play() {
    if (this.t >= this.replay.duration) this.t = 0;
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
    this.t = t;
    this.playing = false;
    this.#show();
  }

  /** @param {number} nowMs @returns {number} the moment to draw, s */
  advance(nowMs) {
    if (this.playing) {
      const elapsed = this.#lastMs ? (nowMs - this.#lastMs) / 1000 : 0;
      this.#lastMs = nowMs;
      // The bin's light fades in real time, however slow the fall was.
      this.t += elapsed * (this.t < this.replay.duration ? this.speed : 1);
      if (this.t >= this.replay.end) this.playing = false;
      this.#show(false);
    }
    return this.t;
  }

  #show(wake = true) {
    const t = Math.min(this.t, this.replay.duration);
    this.slider.value = String(t);
    this.slider.setAttribute("aria-valuetext", seconds(t));
    this.clock.textContent = seconds(t);
    this.button.textContent = this.playing ? "Pause" : "Play";
    if (wake) this.onChange();
  }

  #key(event) {
    if (event.key !== " " || event.target.closest("input, select, button, a")) return;
    event.preventDefault();
    if (!event.repeat) this.toggle();
  }

  #fillFacts() {
    const { record } = this.replay;
    const facts = [
      ["Board", record.board.name ?? record.board],
      ["Seed", record.seed],
      ...(record.x === undefined || record.x === null ? [] : [["Start", `${record.x} m`]]),
      ["Bin", record.bin === null ? "none" : String(record.bin)],
      ["Score", multiplier(record.score)],
      ["Duration", seconds(record.duration)],
      ["Impacts", String(record.impacts.length)],
      ["Digest", record.digest],
    ];
    byId("replay-facts").replaceChildren(...facts.map(([name, value]) => {
      const data = make("dd", {}, String(value));
      data.dataset.fact = name.toLowerCase();
      return make("div", {}, make("dt", {}, name), data);
    }));
  }
}
