// Every event of the store is sent by someone and received by someone.

import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";

const JS = new URL("../../../static/js/", import.meta.url);
const source = (path) => readFileSync(new URL(path, JS), "utf8");
const scripts = ["play", "stage"].flatMap((folder) => readdirSync(new URL(folder, JS), { recursive: true })
  .filter((name) => name.endsWith(".js"))
  .map((name) => source(`${folder}/${name}`)));
const all = scripts.join("\n");

const [, events] = /@typedef \{object\} News([^]*?)\*\//.exec(source("play/store.js"));
const declared = new Set(Array.from(events.matchAll(/@property \{.*\} (\w+)/g), ([, kind]) => kind));
const sent = new Set(Array.from(all.matchAll(/\btell\("(\w+)"/g), ([, kind]) => kind));
// A loop subscribes to several events: for (const kind of ["room", "choice"]) game.on(kind, ...)
const lists = Array.from(all.matchAll(/for \(const kind of [^[]*\[([^\]]*)\]\)\) \w+\.on\(kind,/g), ([, list]) => list);
const received = new Set([
  ...Array.from(all.matchAll(/\b(?:news|game|this)\.on(?:Calm)?\("(\w+)"/g), ([, kind]) => kind),
  ...lists.flatMap((list) => Array.from(list.matchAll(/"(\w+)"/g), ([, kind]) => kind)),
]);

test("the store's events are found", () => {
  assert.ok(declared.size > 20, [...declared].join());
});

for (const kind of declared) {
  test(`${kind} is sent and received`, () => {
    assert.ok(sent.has(kind), `nobody sends ${kind}`);
    assert.ok(received.has(kind), `nobody receives ${kind}`);
  });
}

test("no other event is sent or received", () => {
  assert.deepEqual([...sent].filter((kind) => !declared.has(kind)), []);
  assert.deepEqual([...received].filter((kind) => !declared.has(kind)), []);
});
