// Labelled fields for the numbers of a board, each at its path; what is no number is said beside it.

import { read } from "./draft.js";
import { make } from "../util/dom.js";

/** @typedef {{path: string, label: string, step?: number}} Row step: of the arrow keys */

/** Fields in a box; `onChange(path, value)` tells of a new number. */
export class NumberFields {
  /** @type {Map<string, HTMLInputElement>} */
  #inputs = new Map();
  #notes = new Map();

  /** @param {HTMLElement} box @param {(path: string, value: number) => void} onChange */
  constructor(box, onChange) {
    this.box = box;
    this.onChange = onChange;
  }

  /** @param {Row[]} rows @param {any} board */
  show(rows, board) {
    const paths = rows.map(({ path }) => path);
    const same = paths.length === this.#inputs.size && paths.every((path) => this.#inputs.has(path));
    if (!same) this.#build(rows);
    for (const [path, input] of this.#inputs) {
      const text = String(read(board, path) ?? 0);
      if (input.value !== text) input.value = text;
      this.#say(path, "");
    }
  }

  /**
   * Marks the field that a refusal is about.
   * @param {string | null} path
   * @returns {boolean} whether it is one of these
   */
  mark(path) {
    for (const [each, input] of this.#inputs) {
      const bad = each === path;
      input.parentElement.dataset.bad = String(bad);
      input.setAttribute("aria-invalid", String(bad));
    }
    return this.#inputs.has(path);
  }

  /** @param {string} path */
  focus(path) {
    this.#inputs.get(path)?.focus();
  }

  #build(rows) {
    this.#inputs.clear();
    this.#notes.clear();
    this.box.replaceChildren(...rows.map((row) => this.#field(row)));
  }

  #field({ path, label, step = 0.01 }) {
    const id = `at-${path.replace(/[^a-z0-9]+/gi, "-")}`;
    const note = make("span", { class: "note note-bad", id: `${id}-note` });
    const input = make("input", {
      id, inputmode: "decimal", autocomplete: "off", spellcheck: "false", "data-path": path,
      "aria-describedby": note.id,
    });
    input.addEventListener("change", () => this.#take(path, input.value));
    input.addEventListener("keydown", (event) => {
      const way = { ArrowUp: 1, ArrowDown: -1 }[event.key];
      if (!way) return;
      event.preventDefault();
      const value = Number(input.value) + way * step * (event.shiftKey ? 10 : 1);
      this.#take(path, String(Number(value.toPrecision(12))));
    });
    this.#inputs.set(path, input);
    this.#notes.set(path, note);
    return make("div", { class: "field" }, make("label", { for: id }, label), input, note);
  }

  #take(path, text) {
    const value = Number(text.trim().replace("−", "-").replace(",", "."));
    if (text.trim() === "" || !Number.isFinite(value)) {
      this.#say(path, `“${text.slice(0, 24)}” is not a number.`);
      return;
    }
    this.#say(path, "");
    this.onChange(path, value);
  }

  #say(path, text) {
    this.#notes.get(path).textContent = text;
    this.#inputs.get(path).setAttribute("aria-invalid", String(text !== ""));
  }
}
