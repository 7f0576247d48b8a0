// Labelled fields for the numbers and texts of a board, each for one path, with a note about invalid input.

import { make } from "../util/dom.js";
import { noNumber, readNumber } from "../util/number-text.js";
import { read } from "./draft/draft.js";

/** @import { Board } from "../model/board.js" */
/** @import { Row } from "./rows.js" */

/** The fields in a box; `onChange(path, value)` is called with a new value. */
export class NumberFields {
  /** By path. @type {Map<string, {input: HTMLInputElement, note: HTMLElement, text: boolean}>} */
  #fields = new Map();

  /** @param {HTMLElement} box @param {(path: string, value: number | string) => void} onChange */
  constructor(box, onChange) {
    this.box = box;
    this.onChange = onChange;
  }

  /** @param {Row[]} rows @param {Board} board */
  show(rows, board) {
    const paths = rows.map(({ path }) => path);
    const same = paths.length === this.#fields.size && paths.every((path) => this.#fields.has(path));
    if (!same) {
      this.#fields.clear();
      this.box.replaceChildren(...rows.map((row) => this.#field(row)));
    }
    for (const [path, { input, text }] of this.#fields) {
      const value = String(read(board, path) ?? (text ? "" : 0));
      if (input.value !== value) input.value = value;
      this.#say(path, "");
    }
  }

  /**
   * Marks the field that the server's error is about, if it is one of these.
   * @param {string | null} path
   */
  mark(path) {
    for (const [each, { input }] of this.#fields) input.setAttribute("aria-invalid", String(each === path));
  }

  /** @param {string} path */
  focus(path) {
    this.#fields.get(path)?.input.focus();
  }

  /** @param {Row} row */
  #field({ path, label, step = 0.01, text = false }) {
    const id = `at-${path.replace(/[^a-z0-9]+/gi, "-")}`;
    const note = make("span", { class: "note", "data-tone": "bad", id: `${id}-note` });
    const input = make("input", {
      id, inputmode: text ? "text" : "decimal", autocomplete: "off", spellcheck: "false", "aria-describedby": note.id,
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
    this.#fields.set(path, { input, note, text });
    return make("div", { class: "field" }, make("label", { for: id }, label), input, note);
  }

  /** @param {string} path @param {string} text */
  #take(path, text) {
    if (this.#fields.get(path)?.text) {
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
    const field = this.#fields.get(path);
    if (field) field.note.textContent = text;
    field?.input.setAttribute("aria-invalid", String(text !== ""));
  }
}
