// The one impact that decided the bin: the last that a drop shares with one that started a hair aside.

/** @import { Point } from "../../model/board.js" */
/** @import { Solved } from "../../model/table/solved-feed.js" */

const LEAST = 2 ** -53; // of a metre: a bit of starts about a metre off the middle
const MOST = 0.01; // m: two starts farther apart than this are simply two drops
const WIDER = 4; // each time as far aside
const SAMPLES = 120; // a second, of the other's way

/**
 * @typedef {object} Fork
 * @property {number} t when it was decided, s since the start
 * @property {Point} at where the ball's centre was then, m
 * @property {number} hair how far aside the other started, m
 * @property {number} score what the other's bin pays
 * @property {Point[]} path the other's, from there on, m
 */

/**
 * The nearest start of those tried that leads to another bin; both its paths are exact.
 * @param {Solved} drop that landed
 * @param {(x: number) => Solved} dropAt
 * @param {{from: number, to: number}} starts that the board allows, m
 * @returns {Fork | null} null where no hair changes the bin
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
  while (shared < ours.length && shared < theirs.length && alike(ours[shared], theirs[shared])) {
    shared += 1;
  }
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

/** Whether two impacts are on the same thing. @param {number[]} one @param {number[]} other */
function alike(one, other) {
  return one[6] === other[6] && one[7] === other[7];
}
