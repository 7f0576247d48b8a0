// Labelled fields for the numbers and texts of a board, each for one path, with a note about invalid input.

import { make, parentOf } from "../util/dom.js";
import { noNumber, readNumber } from "../util/number-text.js";
import { read } from "./draft/draft.js";

/** @import { Board } from "../model/board.js" */
/** @import { Row } from "./rows.js" */

/** The fields in a box; `onChange(path, value)` is called with a new value. */
export class NumberFields {
  /** @type {Map<string, HTMLInputElement>} */
  #inputs = new Map();
  /** @type {Map<string, HTMLElement>} */
  #notes = new Map();
  /** @type {Set<string>} paths of texts */
  #texts = new Set();

  /** @param {HTMLElement} box @param {(path: string, value: number | string) => void} onChange */
  constructor(box, onChange) {
    this.box = box;
    this.onChange = onChange;
  }

  /** @param {Row[]} rows @param {Board} board */
  show(rows, board) {
    const paths = rows.map(({ path }) => path);
    const same = paths.length === this.#inputs.size && paths.every((path) => this.#inputs.has(path));
    if (!same) this.#build(rows);
    for (const [path, input] of this.#inputs) {
      const text = String(read(board, path) ?? (this.#texts.has(path) ? "" : 0));
      if (input.value !== text) input.value = text;
      this.#say(path, "");
    }
  }

  /**
   * Marks the field that the server's error is about, if it is one of these.
   * @param {string | null} path
   */
  mark(path) {
    for (const [each, input] of this.#inputs) {
      const bad = each === path;
      parentOf(input).dataset.bad = String(bad);
      input.setAttribute("aria-invalid", String(bad));
    }
  }

  /** @param {string} path */
  focus(path) {
    this.#inputs.get(path)?.focus();
  }

  /** @param {Row[]} rows */
  #build(rows) {
    this.#inputs.clear();
    this.#notes.clear();
    this.#texts = new Set(rows.filter(({ text }) => text).map(({ path }) => path));
    this.box.replaceChildren(...rows.map((row) => this.#field(row)));
  }

  /** @param {Row} row */
  #field({ path, label, step = 0.01, text = false }) {
    const id = `at-${path.replace(/[^a-z0-9]+/gi, "-")}`;
    const note = make("span", { class: "note", "data-tone": "bad", id: `${id}-note` });
    const input = make("input", {
      id, inputmode: text ? "text" : "decimal", autocomplete: "off", spellcheck: "false", "data-path": path,
      "aria-describedby": note.id,
    });
    input.addEventListener("change", () => this.#take(path, input.value));
    input.addEventListener("keydown", (event) => {
      if (text) return;
      const way = event.key === "ArrowUp" ? 1 : event.key === "ArrowDown" ? -1 : 0;
      if (!way) return;
      event.preventDefault();
      const value = (readNumber(input.value) ?? Number.NaN) + way * step * (event.shiftKey ? 10 : 1);
      this.#take(path, Number.isNaN(value) ? input.value : String(Number(value.toPrecision(12))));
    });
    this.#inputs.set(path, input);
    this.#notes.set(path, note);
    return make("div", { class: "field" }, make("label", { for: id }, label), input, note);
  }

  /** @param {string} path @param {string} text */
  #take(path, text) {
    if (this.#texts.has(path)) {
      this.onChange(path, text.trim());
      return;
    }
    const value = readNumber(text);
    if (value === null) {
      this.#say(path, noNumber(text));
      return;
    }
    this.#say(path, "");
    this.onChange(path, value);
  }

  /** @param {string} path @param {string} text */
  #say(path, text) {
    const [note, input] = [this.#notes.get(path), this.#inputs.get(path)];
    if (note) note.textContent = text;
    input?.setAttribute("aria-invalid", String(text !== ""));
  }
}
