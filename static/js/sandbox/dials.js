// Rows of sliders with values and units. They report the player's changes, and show those of others.

import { make } from "../util/dom.js";
import { figure } from "../util/scale.js";

const TOLD_MS = 100; // between two reports while a slider is being moved

/**
 * @typedef {object} Dial
 * @property {string} name
 * @property {string} label
 * @property {number} low
 * @property {number} high
 * @property {string} unit
 * @property {number} [step] of a linear scale
 * @property {boolean} [rare] behind "More"
 * @property {boolean} [log] a logarithmic scale; `low` must be above 0
 * @property {(value: number) => string} [show]
 */

/**
 * @typedef {{dial: Dial, input: HTMLInputElement, output: HTMLOutputElement, held: boolean,
 *   timer: number, release: number}} Slider
 */

/** A column of sliders. */
export class Dials {
  /** @type {Map<string, Slider>} */
  #rows = new Map();

  /**
   * @param {HTMLElement} parent
   * @param {Dial[]} dials
   * @param {(name: string, value: number) => void} [onChange] also called every TOLD_MS during a move
   * @param {HTMLElement} [more] for rare ones
   */
  constructor(parent, dials, onChange = () => {}, more = parent) {
    this.onChange = onChange;
    for (const dial of dials) (dial.rare ? more : parent).append(this.#row(parent.id, dial));
  }

  /** @param {string} name @returns {number} */
  value(name) {
    const row = this.#rows.get(name);
    if (!row) throw new Error(`there is no slider ${name}`);
    const { dial, input } = row;
    // A slider resolves three digits.
    return dial.log ? Number((10 ** Number(input.value)).toPrecision(3)) : Number(input.value);
  }

  /**
   * Shows values, except on a slider that the player is moving.
   * @param {Partial<Record<string, number>>} values
   */
  set(values) {
    for (const [name, row] of this.#rows) {
      const value = values[name];
      if (value === undefined || row.held) continue;
      row.input.value = String(row.dial.log ? Math.log10(value) : value);
      this.#show(row, value);
    }
  }

  /** @param {string} group @param {Dial} dial */
  #row(group, dial) {
    const id = `${group}-${dial.name}`;
    const [low, high] = dial.log ? [Math.log10(dial.low), Math.log10(dial.high)] : [dial.low, dial.high];
    const step = dial.log ? "0.01" : String(dial.step ?? "any");
    const input = make("input", { id, type: "range", min: String(low), max: String(high), step });
    const output = make("output", { for: id });
    const row = { dial, input, output, held: false, timer: 0, release: 0 };
    this.#rows.set(dial.name, row);
    input.addEventListener("input", () => this.#moved(row));
    input.addEventListener("change", () => this.#tell(row));
    this.#show(row, this.value(dial.name));
    return make("div", { class: "dial" }, make("label", { for: id }, dial.label), input, output);
  }

  /** @param {Slider} row */
  #moved(row) {
    row.held = true;
    this.#show(row, this.value(row.dial.name));
    row.timer ||= setTimeout(() => this.#tell(row), TOLD_MS);
  }

  /** @param {Slider} row */
  #tell(row) {
    clearTimeout(row.timer);
    row.timer = 0;
    this.onChange(row.dial.name, this.value(row.dial.name));
    // For a moment the room's answer must not move the slider back under the pointer.
    clearTimeout(row.release);
    row.release = setTimeout(() => {
      row.held = false;
    }, 500);
  }

  /** @param {Slider} row @param {number} value */
  #show({ dial, input, output }, value) {
    const text = dial.show ? dial.show(value) : `${figure(value)} ${dial.unit}`.trim();
    output.textContent = text;
    input.setAttribute("aria-valuetext", text);
  }
}
