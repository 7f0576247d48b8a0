// Addresses of drops: no digit of a seed or a start is lost.

import assert from "node:assert/strict";
import { test } from "node:test";

import { dropPath, readDrop, replayLink } from "../../../static/js/net/drop-address.js";

test("an address keeps every digit", () => {
  const query = "board=triangle-8&seed=18446744073709551615&x=0.1000000000000000055&solver=stepped";
  const drop = readDrop(new URLSearchParams(query));
  assert.equal(replayLink(drop), `replay.html?${query}`);
  assert.equal(
    dropPath(drop, "/frames", new URLSearchParams({ fps: "5" })),
    "drops/triangle-8/18446744073709551615/frames?fps=5&x=0.1000000000000000055&solver=stepped",
  );
});

test("parameters that are not set are not in the address", () => {
  const drop = readDrop(new URLSearchParams("board=classic&seed=7"));
  assert.equal(replayLink(drop), "replay.html?board=classic&seed=7");
  assert.equal(dropPath(drop), "drops/classic/7");
});
