// Decoding of paths: golden messages to the last bit; errors name what is wrong.

import assert from "node:assert/strict";
import { test } from "node:test";

import { decodePaths } from "../../../static/js/net/paths.js";
import { ProtocolError } from "../../../static/js/net/protocol.js";
import { bytesOf, json, knotsOf } from "../support.js";

const { messages } = json("tests/golden/paths.json");

for (const { name, hex, paths } of messages) {
  test(`golden paths decode to the last bit: ${name}`, () => {
    const decoded = decodePaths(bytesOf(hex));
    assert.deepEqual(decoded.map(({ ball }) => ball), paths.map(({ ball }) => ball));
    for (const [i, { knots }] of paths.entries()) assert.deepEqual(decoded[i].knots, knotsOf(knots));
  });
}

const [{ hex: whole }] = messages;
for (const [hex, named] of [
  ["", "0 bytes"],
  [whole.slice(0, 30), "15 bytes"],
  [`50${whole.slice(2)}`, "80, not 70"],
  [`4602${whole.slice(4)}`, "version 2"],
  [whole.slice(0, -2), "99 bytes, not 100"],
  [`${whole}00`, "1 bytes"],
  [`${whole.slice(0, 8)}00000000${whole.slice(16, 32)}`, "0 knots"],
]) {
  test(`bytes that are no path are refused: ${named}`, () => {
    assert.throws(
      () => decodePaths(bytesOf(hex)),
      (error) => error instanceof ProtocolError && error.message.includes(named),
    );
  });
}
