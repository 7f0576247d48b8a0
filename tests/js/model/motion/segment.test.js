// Where a ball is on a segment of its path, compared with the golden file.

import assert from "node:assert/strict";
import { test } from "node:test";

import { segmentPose } from "../../../../static/js/model/motion/segment.js";
import { goldenSegments, near, segmentOf } from "../../support.js";

test("the ball is at the places of the golden file", () => {
  const { scale: law, frames } = goldenSegments();
  assert.ok(frames.length > 0);
  for (const { name, flights, curves, drawn } of frames) {
    const segments = [...flights, ...curves].map(segmentOf);
    assert.equal(drawn.length, 2 * segments.length);
    drawn.forEach(({ at, pose }, i) => {
      const { x, y, angle } = segmentPose(segments[Math.floor(i / 2)], at, law);
      [x, y, angle].forEach((value, k) => {
        near(value, pose[k], 1e-12 + 1e-12 * Math.abs(pose[k]), name);
      });
    });
  }
});
