// A storage that refuses: values stay in memory, nothing throws, and each refused write is reported.

import assert from "node:assert/strict";
import { test } from "node:test";

import { SafeStorage } from "../../../static/js/util/storage.js";
import { storage } from "../support.js";

/** @param {() => unknown} open */
function safe(open) {
  const refused = { count: 0 };
  return { refused, kept: new SafeStorage(open, () => { refused.count += 1; }) };
}

const full = (area) => ({ ...area, setItem: () => { throw new Error("full"); } });

for (const [name, open] of Object.entries({
  "a storage whose access throws": () => { throw new Error("denied"); },
  "a storage that is null": () => null,
  "a storage that throws at every call": () => ({
    getItem: () => { throw new Error("denied"); },
    setItem: () => { throw new Error("denied"); },
    removeItem: () => { throw new Error("denied"); },
  }),
})) {
  test(`${name} keeps values in memory`, () => {
    const { kept, refused } = safe(open);
    assert.equal(kept.getItem("a"), null);
    assert.equal(refused.count, 0);
    assert.equal(kept.setItem("a", "1"), false);
    assert.equal(kept.getItem("a"), "1");
    kept.removeItem("a");
    assert.equal(kept.getItem("a"), null);
    assert.equal(refused.count, 1);
  });
}

test("a refused value hides the older one that the browser stores, until a write succeeds", () => {
  const area = storage();
  area.setItem("a", "old");
  const state = { area: full(area) };
  const { kept } = safe(() => state.area);
  assert.equal(kept.getItem("a"), "old");
  kept.setItem("a", "new");
  assert.equal(kept.getItem("a"), "new");
  kept.setItem("b", "refused too");
  state.area = area;
  assert.equal(kept.setItem("a", "newer"), true);
  assert.equal(area.getItem("b"), "refused too", "what was refused before is stored as well");
  assert.equal(kept.getItem("a"), "newer");
  area.setItem("a", "another tab's");
  assert.equal(kept.getItem("a"), "another tab's");
});

test("a read stores what was refused, as soon as the browser takes writes again", () => {
  const area = storage();
  const state = { area: full(area) };
  const { kept } = safe(() => state.area);
  kept.setItem("a", "new");
  assert.deepEqual([kept.getItem("a"), area.getItem("a")], ["new", null]);
  state.area = area;
  assert.deepEqual([kept.getItem("a"), area.getItem("a")], ["new", "new"]);
});
