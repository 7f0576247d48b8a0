// The ESLint rule that no module of the pages contains text for people.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Linter } from "eslint";

import { ownWords } from "../../../tools/own-words.js";

/** @param {string} code @returns {number} how many errors the rule reports */
function complaints(code) {
  const plugins = { texts: { rules: { "own-words": ownWords } } };
  return new Linter().verify(code, [{ plugins, rules: { "texts/own-words": "error" } }]).length;
}

test("text for people is found, however it reaches the page", () => {
  for (const code of [
    'note.textContent = "Nothing has landed";',
    "say(`There are ${count} balls`);",
    'button.setAttribute("aria-label", "Close");',
    'make("button", { title: "Use it again" });',
    'const label = running ? "Stop" : "Start it";',
    'const rows = [["Seed", seed]];',
    'say("It landed" + where);',
  ]) assert.ok(complaints(code) > 0, code);
});

test("names, keys, selectors and messages of errors are allowed", () => {
  for (const code of [
    'say(t("play.first"));',
    'make("p", { class: "small strong" });',
    'form.querySelector("input select");',
    'if (event.key === "Escape") stop();',
    'throw new Error("the page has no such element");',
    'const GRAVITY = { "Clay and putty": 1 };',
    'ctx.font = `700 ${size}px Arial Narrow`;',
    'switch (key) { case "Enter": go(); }',
  ]) assert.equal(complaints(code), 0, code);
});
