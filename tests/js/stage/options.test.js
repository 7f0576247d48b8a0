// A stage's address has options; missing and invalid ones have their defaults.

import assert from "node:assert/strict";
import { test } from "node:test";

import { readOptions } from "../../../static/js/stage/options.js";

const read = (search) => readOptions(new URLSearchParams(search));

const PLAIN = { room: "main", ground: null, plate: true, names: true, winners: true, leaders: "best", queue: true, join: false, tray: null, expected: null, sound: false };

test("by default everything is shown, and sound is off", () => {
  assert.deepEqual(read(""), PLAIN);
});

test("each part has its own switch", () => {
  assert.deepEqual(read("room=abc"), { ...PLAIN, room: "abc" });
  assert.deepEqual(read("plate=off"), { ...PLAIN, plate: false });
  assert.deepEqual(read("names=off"), { ...PLAIN, names: false });
  assert.deepEqual(read("winners=off"), { ...PLAIN, winners: false });
  assert.deepEqual(read("queue=off"), { ...PLAIN, queue: false });
  assert.deepEqual(read("join=on"), { ...PLAIN, join: true });
  assert.deepEqual(read("leaders=off"), { ...PLAIN, leaders: null });
  assert.deepEqual(read("leaders=prizes"), { ...PLAIN, leaders: "prizes" });
  assert.deepEqual(read("tray=pile"), { ...PLAIN, tray: "pile" });
  assert.deepEqual(read("tray=bars&expected=on"), { ...PLAIN, tray: "bars", expected: "on" });
  assert.deepEqual(read("expected=binomial"), { ...PLAIN, expected: "binomial" });
  assert.deepEqual(read("sound=on"), { ...PLAIN, sound: true });
});

test("a backdrop is transparent or a colour, and nothing else", () => {
  assert.deepEqual(
    ["transparent", "00B140", "#00b140", "red", "url(x)", "00b1400", ""].map((ground) => read({ ground }).ground),
    ["transparent", "#00b140", "#00b140", null, null, null, null],
  );
});

test("invalid options are ignored", () => {
  assert.deepEqual(read("leaders=nobody&tray=on&expected=off&plate=maybe&winners=&sound=loud&room="), PLAIN);
});
