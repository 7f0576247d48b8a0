// How close our ball came to a better bin, in words. Pure.

import { prizeOf } from "../../paint/prizes.js";
import { t } from "../../texts/text.js";

/** @import { Board } from "../../model/board.js" */

const NEAR = 0.5; // ball radii from the ball's centre to the edge between the bins
const MORE = 3; // the better bin pays at least this many times as much, and
const LEAST = 2; // at least this multiplier

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
