// What a landing leaves on the board: the impact that decided the bin and, for a win, light along the pegs it hit.

import { startSpan } from "../../model/board.js";
import { PEG } from "../../model/motion/kinds.js";
import { JACKPOT, WIN } from "./celebration.js";
import { findFork } from "./fork.js";

/** @import { Board, Peg, Point } from "../../model/board.js" */
/** @import { Flash, Scene } from "../../model/scene.js" */
/** @import { Solved } from "../../model/table/path-feed.js" */
/** @import { Fork } from "./fork.js" */

const RUN_S = 1.1; // for the light from the first peg to the last
const FADE_S = 0.7;
const SLOW_S = 2; // of slow motion
const NEAR_S = 0.45; // for zooming in before it
const AROUND_S = 0.14; // of the drop shown before and after the deciding impact
const TRAIL = 10;
const TRAIL_S = 0.008;

/** Shows our last landing until another ball falls. */
export class LandingZoom {
  /** @type {{drop: Solved, pegs: Peg[], fork: Fork | null, score: number, slow: boolean} | null} */
  #shown = null;
  /** @type {number | null} local time at which it began, s */
  #since = null;

  clear() {
    this.#shown = null;
    this.near = null;
  }

  /**
   * @param {Solved} drop one that has landed
   * @param {Board} board
   * @param {(x: number) => Solved} dropAt
   * @param {boolean} still whether motion is reduced
   */
   begin(drop, board, dropAt, still) {
    const pegs = drop.impacts.filter((row) => row[6] === PEG).map((row) => board.pegs[row[7]]);
    const { x } = board.drop;
    const span = startSpan(board.drop);
    const fork = findFork(drop, dropAt, { from: x - span, to: x + span });
    const slow = !still && fork !== null && drop.score >= JACKPOT;
    this.#shown = { drop, pegs, fork, score: drop.score, slow };
    this.#since = null;
  }

  /** The deciding impact of a jackpot, while the view is zoomed in on it. @type {Point | null} */
  near = null;

  /** Whether the zoom on a jackpot is due or running: nothing else is shown over it. */
  get looking() {
    return this.#shown !== null && this.#shown.slow && (this.#since === null || this.near !== null);
  }

  /**
   * Adds it to a scene.
   * @param {Scene} scene
   * @param {number} wall local time, s
   * @param {boolean} still whether motion is reduced
   * @param {boolean} lab whether the Lab is open, which also shows the path of a ball with a shifted start
   * @returns {boolean} whether it still moves
   */
  show(scene, wall, still, lab) {
    scene.fork = null;
    if (!this.#shown) return false;
    const { drop, pegs, fork, score, slow } = this.#shown;
    this.#since ??= wall;
    const age = wall - this.#since;
    if (lab) scene.fork = fork;
    if (still || score < WIN) return false;
    const before = slow ? NEAR_S + SLOW_S : 0;
    this.near = slow && age < before && fork ? fork.at : null;
    if (this.near && fork) {
      const part = Math.max(0, age - NEAR_S) / SLOW_S;
      scene.balls.push(this.#slowBall(drop, fork.t + (part - 0.5) * 2 * AROUND_S));
      return true;
    }
    scene.flashes = [...scene.flashes, ...lights(pegs, age - before)];
    return age < before + RUN_S + FADE_S;
  }

  /** @param {Solved} drop @param {number} t s since its start */
  #slowBall(drop, t) {
    const times = Array.from({ length: TRAIL }, (_, i) => Math.max(0, t - i * TRAIL_S));
    const trail = drop.states(times);
    const [{ x, y }] = trail;
    return { x, y, angle: 0, mine: true, trail };
  }
}

/** @param {Peg[]} pegs in the order in which they were hit @param {number} age s @returns {Flash[]} */
function lights(pegs, age) {
  return pegs
    .map(({ x, y, radius }, i) => {
      const since = age - (RUN_S * i) / Math.max(1, pegs.length - 1);
      return { x, y, radius, age: since / FADE_S, strength: 1 };
    })
    .filter((flash) => flash.age >= 0 && flash.age < 1);
}
