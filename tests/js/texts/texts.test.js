// The texts of all languages have the same keys and placeholders, all plural forms, and are all used.

import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";

import { t } from "../../../static/js/texts/text.js";

const STATIC = new URL("../../../static/", import.meta.url);
const FOLDER = new URL("js/texts/", STATIC);
const names = readdirSync(FOLDER).filter((name) => /^[a-z]{2}\.json$/.test(name));
const languages = new Map(names.map((name) =>
  [name.slice(0, 2), JSON.parse(readFileSync(new URL(name, FOLDER), "utf8"))]));
const english = languages.get("en");

/** The placeholders of a text, each once, in alphabetical order. @param {string} text */
const placesOf = (text) => [...new Set(text.match(/\{\w*\}/g) ?? [])].sort();
const formsOf = (text) => (typeof text === "string" ? [text] : Object.values(text));

/** @param {RegExp} ending @returns {string[]} all files of the pages with that ending */
const sources = (ending) => readdirSync(STATIC, { recursive: true })
  .filter((path) => ending.test(path))
  .map((path) => readFileSync(new URL(path, STATIC), "utf8"));

test("every language has the same texts, in the same order", () => {
  assert.ok(languages.size >= 3);
  for (const [language, texts] of languages) {
    assert.equal(texts.language, language);
    assert.deepEqual(Object.keys(texts), Object.keys(english));
  }
});

test("a text has the same placeholders in all languages and forms", () => {
  for (const [language, texts] of languages) {
    for (const [key, text] of Object.entries(texts)) {
      const expected = placesOf(formsOf(english[key]).at(-1));
      for (const form of formsOf(text)) {
        assert.ok(form.trim(), `${language}: ${key} is empty`);
        assert.equal(form, form.trim(), `${language}: ${key} begins or ends with a space`);
        const found = placesOf(form).join();
        assert.equal(found, expected.join(), `${language}: ${key}`);
      }
    }
  }
});

test("a text with forms has every language's plural categories", () => {
  for (const [language, texts] of languages) {
    // Only smaller numbers occur: from a million on, Spanish has another category with the same form.
    const rules = new Intl.PluralRules(language);
    const needed = new Set([0, 1, 2, 3, 4, 5, 11, 21, 100].map((count) => rules.select(count)));
    for (const [key, text] of Object.entries(texts)) {
      assert.equal(typeof text, typeof english[key], `${language}: ${key}`);
      if (typeof text === "string") continue;
      assert.deepEqual(new Set(Object.keys(text)), needed, `${language}: ${key}`);
    }
  }
});

/** What a player's text must not say: another word than the language's one for a thing, or what nobody says. */
const FOREIGN = {
  en: /\bdrops?\b|\bkept under\b|\bothers? (?:is|are) here|only grew|is marked|shifted by|found here/i,
  de: /abw[ue]rf|wirft .* ab\b|\bseeds?\b|startwert|\bquoten?\b|in dieser seite|kiste|stoßen sich|sich stoßen/i,
  es: /lanzamiento|instantáneo|dinero de juego|demostrable|resumen/i,
};
// English has one word for the noun, ball, and another for the verb.
const VERB = /^Drop\b|Test-drop|\b(?:to|you) drop\b|\bdrops (?=a ball|\{n\} ball)|^Last drops$/g;

test("each language has one word for a thing", () => {
  for (const [language, texts] of languages) {
    for (const [key, text] of Object.entries(texts)) {
      for (const form of formsOf(text)) {
        const said = (language === "en" ? form.replace(VERB, "") : form).replace(/\{\w+\}/g, "");
        assert.doesNotMatch(said, FOREIGN[language], `${language}: ${key}`);
      }
    }
  }
});

test("players read the words that they know", () => {
  const [en, de, es] = ["en", "de", "es"].map((language) => languages.get(language));
  assert.deepEqual(
    [en["word.drop"], en["page.today"], en["play.first"], en["play.locked"], en["fair.mark"].slice(0, 20)],
    ["Drop", "Ball of the day", "Ready when you are.", "Locked until your balls land.", "Saved on this device"],
  );
  assert.deepEqual(
    [de["word.seed"], de["fact.score"], de["editor.undo"], de["editor.redo"], de["editor.duplicate"], de["play.last"]],
    ["Startzahl", "Faktor", "Rückgängig", "Wiederholen", "Duplizieren", "Letzte Würfe"],
  );
  assert.ok(de["replay.same-here"].other.startsWith("Auf dieser Seite nachgerechnet"));
  assert.ok(es["pace.note"].includes(es["pace.instant"]), "as on its button");
  assert.deepEqual(
    [es["pace.instant"], es["play.sealed"], es["play.play-money"], es["fact.digest"], es["play.last"]],
    ["Al instante", "Juego limpio verificable", "Dinero ficticio, sin valor", "Hash", "Últimas tiradas"],
  );
});

test("every text is used, and every used key has a text", () => {
  const code = sources(/\.js$/).join("\n");
  const pages = sources(/\.(?:html|part)$/).join("\n");
  const used = new Set([...pages.matchAll(/(?:\{\{|\w=)([a-z]+\.[\w-]+|language)(?=[|} ])/g)].map(([, key]) => key));
  for (const key of used) assert.ok(key in english, `a page uses ${key}`);
  const unused = Object.keys(english).filter((key) => !used.has(key) && !code.includes(`"${key}"`));
  assert.deepEqual(unused, []);
});

test("a page has no text of its own in tags or attributes", () => {
  const same = /^(?:Plink|o|[A-Z]|Esc|English|Deutsch|Español|Plinko|[\d.]+ (?:[pnµm]m|cm|s)|\d+x|api\/\S+|–)$/;
  const parts = /<!--.*?-->|<script.*?<\/script>|<(?:[^>"]|"[^"]*")*>|\{\{[^|{}]*\}\}/gs;
  for (const page of sources(/\.(?:html|part)$/)) {
    const whole = page.replace(/\{\{[\w.-]+\|(.*?)\}\}/g, "$1");
    const words = whole.replace(parts, "\n").split("\n");
    const said = /(?:aria-label|aria-roledescription|title|placeholder|alt|label)="([^"]*)"/g;
    for (const [, text] of whole.matchAll(said)) words.push(text.replace(parts, ""));
    const own = words.map((text) => text.trim()).filter((text) => /\p{L}/u.test(text) && !same.test(text));
    assert.deepEqual(own, []);
  }
});

test("placeholders are filled, numbers by the language's rules", () => {
  assert.equal(t("today.of", { right: 3, played: 16 }), "3 of 16");
  assert.equal(t("count.drop", { n: 1 }), "1 ball");
  assert.equal(t("count.drop", { n: 12345 }), "12,345 balls");
  assert.equal(t("play.replay-seed", { board: "b", seed: "12345678901234567890" }),
    "Replay seed 12345678901234567890 on b");
});
