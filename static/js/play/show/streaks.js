// The paths of drops at the pace "instant": lines that light up and fade.

/** @import { Scene, Streak } from "../../model/scene.js" */
/** @import { Solved } from "../../model/table/path-feed.js" */

const LASTS_S = 1.1;
const MOST = 12; // older ones are removed
const SAMPLES = 90; // points a second of a fall

/** The lines on one board. */
export class Streaks {
  /** @type {(Streak & {since: number | null})[]} since: local time at which it was first shown, s */
  #streaks = [];

  clear() {
    this.#streaks.length = 0;
  }

  /** @param {Solved} drop */
  add(drop) {
    const count = Math.max(2, Math.ceil(drop.duration * SAMPLES));
    const times = Array.from({ length: count }, (_, i) => (drop.duration * i) / (count - 1));
    const points = drop.states(times).map(({ x, y }) => ({ x, y }));
    this.#streaks.push({ points, age: 0, since: null });
    if (this.#streaks.length > MOST) this.#streaks.shift();
  }

  /** @param {Scene} scene @param {number} wall local time, s @returns {boolean} whether any is visible */
  show(scene, wall) {
    for (const streak of this.#streaks) {
      streak.since ??= wall;
      streak.age = (wall - streak.since) / LASTS_S;
    }
    this.#streaks = this.#streaks.filter(({ age }) => age < 1);
    scene.streaks = this.#streaks;
    return this.#streaks.length > 0;
  }
}
