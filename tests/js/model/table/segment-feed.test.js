// Keyframes from segments, as time passes.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Path } from "../../../../static/js/model/motion/path.js";
import { SegmentFeed } from "../../../../static/js/model/table/segment-feed.js";

test("a ball on a peg is drawn at rest until its next segment", () => {
  // Neither a bounce nor a flight is guessed, although the velocity does not change as in flight.
  const board = { gravity: 25, drag: 0, pegs: [], walls: [], bins: { y: 9 } };
  const path = new Path(board);
  const feed = new SegmentFeed(path, board, { stop: () => false }, 60);
  const segment = { kind: 2, index: 0, t: 0, x: 0, y: 1, vx: 0, vy: 0, angle: 0, spin: 0 };
  feed.add({ ...segment, bend: { ax: 0, ay: 0 } });
  feed.add({ ...segment, t: 2.5 / 60 });
  feed.until(2.5 / 60);
  assert.deepEqual([0.5, 1.5, 2.25].map((tick) => path.poseAt(tick / 60).y), [1, 1, 1]);
});
