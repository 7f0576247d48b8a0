// How the page's scripts are written, and which folder may use which.
//
// static/js is a stack: a folder uses those before it in LAYERS and itself, never one after it. A
// page's own folder is used by no other, but by today, which shows a replay, by stage, which shows a live room, and by pupil.
// Types that JSDoc imports follow the same rule; tests/js/folders.test.js sees to those.

import js from "@eslint/js";
import { importX } from "eslint-plugin-import-x";

import { ownWords } from "./tools/own-words.js";

/** Folders of static/js from the ground up. */
export const LAYERS = ["texts", "util", "model", "solver", "fairness", "net", "paint", "board", "instruments"];
export const PAGES = ["play", "replay", "editor", "sandbox", "verify", "stage", "today", "class", "pupil"];

/** @type {Record<string, string[]>} pages that show what another page has */
const SHOWS = { today: ["replay"], stage: ["play"], pupil: ["class"] };

/** @param {string} folder @returns {string[]} what it must not import */
export function forbidden(folder) {
  const at = LAYERS.indexOf(folder);
  const above = at < 0 ? [] : LAYERS.slice(at + 1);
  const used = [folder, ...(SHOWS[folder] ?? [])];
  return [...above, ...PAGES.filter((page) => !used.includes(page))];
}

const layers = [...LAYERS, ...PAGES].map((folder) => ({
  files: [`static/js/${folder}/**`],
  rules: {
    "no-restricted-imports": ["error", {
      patterns: [{
        group: forbidden(folder).map((other) => `**/${other}/*`),
        message: `${folder}/ may not use it: see the order of folders in eslint.config.js.`,
      }],
    }],
  },
}));

// What a browser may refuse to store goes through static/js/util/storage.js, which never throws.
const STORES = ["localStorage", "sessionStorage", "indexedDB", "caches"];
const REFUSED = "The browser may refuse it: use util/storage.js.";
const stores = {
  "no-restricted-globals": ["error", ...STORES.map((name) => ({ name, message: REFUSED }))],
  "no-restricted-properties": ["error", ...STORES.flatMap((property) =>
    ["window", "globalThis", "self"].map((object) => ({ object, property, message: REFUSED })))],
};

export default [
  { ignores: [".*/**", "artifacts/**", "benchmarks/**", "build/**", "dist/**"] },
  js.configs.recommended,
  {
    plugins: { "import-x": importX },
    rules: {
      "import-x/no-cycle": "error",
      "import-x/no-self-import": "error",
      "import-x/no-useless-path-segments": "error",
      "no-undef": "off", // tsc knows what a browser has
      curly: ["error", "multi-line"],
      eqeqeq: "error",
      "no-console": "error",
      "no-control-regex": "off", // one asks whether text is plain
      "no-eval": "error",
      "no-implicit-coercion": "error",
      "no-var": "error",
      "object-shorthand": "error",
      "prefer-const": "error",
      "prefer-template": "error",
      "no-warning-comments": ["error", { terms: ["@ts-ignore", "@ts-nocheck", "eslint-disable"] }],
    },
  },
  {
    files: ["static/js/**"],
    // What files hold is the same in every language, and so is what the engine says of them.
    ignores: ["static/js/solver/**", "static/js/fairness/export.js",
      "static/js/model/motion/event-names.js"],
    plugins: { texts: { rules: { "own-words": ownWords } } },
    rules: { "texts/own-words": "error" },
  },
  { files: ["static/js/**"], ignores: ["static/js/util/storage.js"], rules: stores },
  { files: ["examples/**"], rules: { "no-console": "off" } }, // an example prints
  ...layers,
];
