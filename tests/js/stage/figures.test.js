// The show on the stage: how its timer reads.

import assert from "node:assert/strict";
import test from "node:test";

import { clock } from "../../../static/js/stage/figures.js";

test("a timer shows whole seconds, and ends with the last one", () => {
  const cases = /** @type {const} */ ([
    [0, "0:00"], [-3, "0:00"], [0.2, "0:01"], [59.5, "1:00"], [184, "3:04"], [7384, "2:03:04"], [360_000, "100:00:00"],
  ]);
  for (const [left, text] of cases) assert.equal(clock(left), text);
});
