// Finds the impact that decided the bin: the last that the drop shares with a drop from a minimally shifted start.

/** @import { Point } from "../../model/board.js" */
/** @import { Solved } from "../../model/table/path-feed.js" */

const LEAST = 2 ** -53; // m: the spacing of doubles just below 1 m
const MOST = 0.01; // m: two starts farther apart are simply two drops
const WIDER = 4; // factor between two tried shifts
const SAMPLES = 120; // points a second of the other path

/**
 * @typedef {object} Fork
 * @property {number} t when the bin was decided, s since the start
 * @property {Point} at where the ball's centre was then, m
 * @property {number} hair the shift of the other start, m
 * @property {number} score the multiplier of the other bin
 * @property {Point[]} path of the other ball from there on, m
 */

/**
 * Finds the smallest tried shift of the start that leads to another bin. Both paths are exact.
 * @param {Solved} drop one that has landed
 * @param {(x: number) => Solved} dropAt
 * @param {{from: number, to: number}} starts the range that the board allows, m
 * @returns {Fork | null} null if no shift changes the bin
 */
export function findFork(drop, dropAt, { from, to }) {
  for (let hair = LEAST; hair <= MOST; hair *= WIDER) {
    for (const x of [drop.xStart - hair, drop.xStart + hair]) {
      if (x === drop.xStart || x < from || x > to) continue;
      const other = dropAt(x);
      if (other.bin !== null && other.bin !== drop.bin) return forkOf(drop, other);
    }
  }
  return null;
}

/** @param {Solved} drop @param {Solved} other @returns {Fork} */
function forkOf(drop, other) {
  const [ours, theirs] = [drop.impacts, other.impacts];
  let shared = 0;
  // As long as both hit the same peg or wall.
  while (ours[shared] && ours[shared][6] === theirs[shared]?.[6] && ours[shared][7] === theirs[shared][7]) shared += 1;
  const [t, x, y] = shared > 0 ? ours[shared - 1] : [0, drop.xStart, drop.states([0])[0].y];
  const from = shared > 0 ? theirs[shared - 1][0] : 0;
  const count = Math.max(2, Math.ceil((other.duration - from) * SAMPLES));
  const times = Array.from({ length: count }, (_, i) => from + ((other.duration - from) * i) / (count - 1));
  return {
    t,
    at: { x, y },
    hair: Math.abs(other.xStart - drop.xStart),
    score: other.score,
    path: other.states(times).map((state) => ({ x: state.x, y: state.y })),
  };
}
