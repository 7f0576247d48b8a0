// Decoding of segments: golden messages to the last bit; errors name what is wrong.

import assert from "node:assert/strict";
import { test } from "node:test";

import { ProtocolError } from "../../../static/js/net/protocol.js";
import { decodeSegments } from "../../../static/js/net/segments.js";
import { bytesOf, goldenSegments, segmentOf } from "../support.js";

const { scale, frames } = goldenSegments();
const SCALE = {
  extent: scale.extent,
  velocityScale: scale.velocity_scale,
  spinScale: scale.spin_scale,
  rate: scale.tick_rate,
};

test("golden messages decode to the last bit", () => {
  assert.ok(frames.length > 0);
  for (const example of frames) {
    const { tick, seq, full, flights, curves } = decodeSegments(bytesOf(example.hex), SCALE);
    assert.deepEqual([tick, seq, full], [example.tick, example.seq, example.full], example.name);
    assert.deepEqual(flights, example.flights.map(segmentOf), example.name);
    assert.deepEqual(curves, example.curves.map(segmentOf), example.name);
  }
});

for (const [hex, said] of [
  ["", "shorter than their header"],
  [`50${"00".repeat(15)}`, "start with 80"],
  [`5301${"00".repeat(14)}`, "version 1"],
  [`${frames[0].hex}00`, "35 bytes, not 34"],
]) {
  test(`a damaged message is refused: ${said}`, () => {
    assert.throws(
      () => decodeSegments(bytesOf(hex), SCALE),
      (error) => error instanceof ProtocolError && error.message.includes(said),
    );
  });
}
