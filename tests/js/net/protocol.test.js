// Decoding of snapshots and events: golden ones to the last bit; errors name what is wrong.

import assert from "node:assert/strict";
import { test } from "node:test";

import { decodeEvents, decodeSnapshot, ProtocolError } from "../../../static/js/net/protocol.js";
import { bytesOf, json } from "../support.js";

test("golden snapshots decode to the last bit", () => {
  const { snapshots } = json("tests/golden/snapshots.json");
  assert.ok(snapshots.length > 0);
  for (const { name, hex, extent, velocity_scale: velocityScale, tick, seq, balls } of snapshots) {
    const decoded = decodeSnapshot(bytesOf(hex), { extent, velocityScale }, tick);
    const wanted = balls.map(({ id, x, y, theta: angle, vx, vy, asleep, bounced }) => (
      { id, x, y, angle, vx, vy, asleep, bounced }));
    assert.deepEqual(decoded, { tick, seq, balls: wanted }, name);
  }
});

test("a snapshot's tick is the one with its last 32 bits nearest to a known tick", () => {
  const extent = { x_min: 0, x_max: 1, y_min: 0, y_max: 1 };
  for (const [bits, near, tick] of [
    ["58020000", 590, 600], ["58020000", 2 ** 32 + 590, 2 ** 32 + 600], ["58020000", 2 ** 32 - 5, 2 ** 32 + 600],
    ["fbffffff", 2 ** 32 + 2, 2 ** 32 - 5], ["fbffffff", 3 * 2 ** 32 - 90, 3 * 2 ** 32 - 5],
  ]) {
    const snapshot = decodeSnapshot(bytesOf(`50010000${bits}11000000`), { extent, velocityScale: 1 }, near);
    assert.equal(snapshot.tick, tick);
  }
});

for (const [hex, named] of [
  ["50", "1 bytes"],
  ["510100005802000011000000", "81"],
  ["500200005802000011000000", "version 2"],
  ["500101005802000011000000", "not 24"],
  ["50010000580200001100000000", "not 12"],
]) {
  test(`bytes that are not a snapshot are refused: ${named}`, () => {
    const extent = { x_min: 0, x_max: 1, y_min: 0, y_max: 1 };
    assert.throws(
      () => decodeSnapshot(bytesOf(hex), { extent, velocityScale: 1 }, 0),
      (error) => error instanceof ProtocolError && error.message.includes(named),
    );
  });
}

test("golden events decode one by one and as a tick's array", () => {
  const { events } = json("tests/golden/events.json");
  assert.ok(events.length > 0);
  for (const { text, value } of events) assert.deepEqual(decodeEvents(text), [value]);
  const whole = `[${events.map(({ text }) => text).join(",")}]`;
  assert.deepEqual(decodeEvents(whole), events.map(({ value }) => value));
});

for (const text of ["", "{", "3", "null", "[null]", '{"type":"hello","protocol":1}']) {
  test(`text that is not an event is refused: ${text}`, () => {
    assert.throws(() => decodeEvents(text), (error) =>
      error instanceof ProtocolError && /event|protocol 1/.test(error.message));
  });
}
