// Sentences about our ball: how far it has fallen, and how close it came to a better bin. Pure.

import { prizeOf } from "../../paint/prizes.js";
import { t } from "../../texts/text.js";

/** @import { Board } from "../../model/board.js" */
/** @import { SceneBall } from "../../model/scene.js" */

const NEAR = 0.5; // ball radii from the ball's centre to the edge between the bins
const MORE = 3; // the better bin pays at least this many times as much, and
const LEAST = 2; // at least this multiplier
const TIMES = 4; // sentences a fall: few enough that a screen reader can finish each

/** Describes the fall of one ball at a time. */
export class Falling {
  /** @type {number[]} the rows of pegs from the top, y in m */
  #rows = [];
  /** @type {Board["bins"] | null} */
  #bins = null;
  /** @type {number | undefined} */
  #ball;
  #told = 0;
  /** Whether another message has priority. */
  silent = false;

  /** @param {Board} board */
  setBoard({ pegs, bins }) {
    this.#rows = [...new Set(pegs.map(({ y }) => Number(y.toFixed(6))))].sort((a, b) => a - b);
    this.#bins = bins;
    this.#ball = undefined;
    this.silent = false;
  }

  /**
   * @param {SceneBall[]} balls in flight
   * @returns {string | null} a sentence, if our only ball has come far enough since the last one
   */
  words(balls) {
    const own = balls.filter(({ mine }) => mine);
    const [ball] = own;
    if (this.silent || own.length !== 1 || !this.#bins || ball.y > this.#bins.y) return null;
    const passed = this.#rows.filter((y) => y < ball.y).length;
    const part = 1 + Math.floor((TIMES * passed) / (this.#rows.length + 1));
    if (ball.id !== this.#ball) this.#told = 0;
    this.#ball = ball.id;
    if (part <= this.#told) return null;
    this.#told = part;
    if (passed === 0) return t("play.falls");
    const told = { row: passed, rows: this.#rows.length };
    const { edges, multipliers } = this.#bins;
    const bin = edges.findIndex((edge, i) => ball.x >= edge && ball.x < edges[i + 1]);
    if (bin < 0) return t("play.row", told);
    return t("play.row-above", { ...told, pays: prizeOf({ bins: this.#bins }, bin, multipliers[bin]) });
  }
}

/**
 * @param {Pick<Board, "ball" | "bins">} board
 * @param {number} bin in which the ball landed
 * @param {number} x where its centre crossed the bins' line, m
 * @returns {string} a sentence, or ""
 */
export function nearMiss({ ball, bins }, bin, x) {
  const { edges, multipliers } = bins;
  const sides = [
    { other: bin - 1, away: x - edges[bin] },
    { other: bin + 1, away: edges[bin + 1] - x },
  ];
  const near = sides.filter(({ other, away }) => away >= 0 && away < NEAR * ball.radius
    && multipliers[other] >= Math.max(LEAST, MORE * multipliers[bin]));
  if (near.length === 0) return "";
  const [{ other }] = near;
  return t("play.near", { pays: prizeOf({ bins }, other, multipliers[other]) });
}
