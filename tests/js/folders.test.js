// The folders of static/js: imports, also of types, go in one direction, and every export is used.

import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";

import { forbidden, LAYERS, PAGES } from "../../eslint.config.js";

const ROOT = new URL("../../static/js/", import.meta.url);
const FOLDERS = [...LAYERS, ...PAGES];

const texts = new Map(
  readdirSync(ROOT, { recursive: true })
    .filter((path) => path.endsWith(".js"))
    .map((path) => [path, readFileSync(new URL(path, ROOT), "utf8")]),
);

/** The imports of a file, also of types in JSDoc and those at run time: imported names by path below static/js. */
function importsOf(path) {
  const found = [];
  const form = /(?:^import|@import|^export)\s+\{([^}]*)\}\s+from\s+"(\.[^"]+)"/gm;
  const later = /(?<!typeof )\bimport\("(\.[^"]+)"\)/g;
  const targetOf = (from) => new URL(from, new URL(path, ROOT)).href.slice(ROOT.href.length);
  for (const [, names, from] of texts.get(path).matchAll(form)) {
    const list = names.split(",").map((name) => name.trim().split(/\s+as\s+/)[0]);
    found.push({ target: targetOf(from), names: list.filter(Boolean) });
  }
  // What is imported later is used by its name in the importing file.
  for (const [, from] of texts.get(path).matchAll(later)) {
    found.push({ target: targetOf(from), names: texts.get(path).match(/\w+/g) });
  }
  return found;
}

test("every file is in a folder of the order", () => {
  for (const path of texts.keys()) assert.ok(FOLDERS.includes(path.split("/")[0]), path);
});

test("imports, also of types, go one way and find their targets", () => {
  for (const path of texts.keys()) {
    const barred = forbidden(path.split("/")[0]);
    for (const { target } of importsOf(path)) {
      assert.ok(texts.has(target), `${path} imports ${target}, which does not exist`);
      assert.ok(!barred.includes(target.split("/")[0]), `${path} imports ${target}`);
    }
  }
});

test("an export is used by another file or in the file itself", () => {
  const imported = new Set();
  for (const path of texts.keys()) {
    for (const { target, names } of importsOf(path)) {
      for (const name of names) for (const end of [".js", ".device.js"]) imported.add(`${target.replace(/\.js$/, end)}:${name}`);
    }
  }
  const unused = [];
  for (const [path, text] of texts) {
    for (const [, name] of text.matchAll(/^export (?:async )?(?:function\*?|class|const) (\w+)/gm)) {
      const uses = text.match(new RegExp(`(?<![\\w.#])${name}\\b`, "g")).length;
      if (uses < 2 && !imported.has(`${path}:${name}`)) unused.push(`${path}: ${name}`);
    }
  }
  assert.deepEqual(unused, []);
});
