// The name and colour that a visitor chose: stored, sent to tables, and valid.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { nameOf, Self } from "../../../../static/js/play/account/self.js";
import { storage } from "../../support.js";

test("the choice is sent in all tabs, without empty fields", () => {
  const kept = storage();
  const self = new Self(kept);
  assert.deepEqual(self.message, { type: "appear" });
  self.change({ name: "Ada", colour: "" });
  assert.deepEqual(new Self(kept).message, { type: "appear", name: "Ada" });
  self.change({ name: "", colour: "#57c7ff" });
  assert.deepEqual(self.message, { type: "appear", colour: "#57c7ff" });
});

test("a name is normalised, and invisible text is refused", () => {
  assert.equal(nameOf("  Ada \t L. "), "Ada L.");
  assert.equal(nameOf("Jose\u0301"), "Jos\u00e9");
  assert.equal(nameOf(""), "");
  for (const name of ["<b>", "a&b"]) assert.equal(nameOf(name), null);
});

test("the page accepts and refuses the names that the server does", () => {
  const { valid, invalid } = JSON.parse(readFileSync("tests/golden/names.json", "utf-8"));
  for (const name of Object.values(valid).flat()) assert.equal(nameOf(name), name.normalize("NFC"));
  const outside = /^\s|\s$|\s\s|[^\S ]/; // spaces that the page takes away
  const refused = Object.values(invalid).flat().filter((name) => !outside.test(name));
  for (const name of refused) assert.equal(nameOf(name), null, JSON.stringify(name));
});

test("invalid stored values are not sent", () => {
  const kept = storage();
  kept.setItem("plinko.visitor.1", JSON.stringify({ name: "<i>", colour: "red;x" }));
  assert.deepEqual(new Self(kept).message, { type: "appear" });
});
