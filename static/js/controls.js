// The desk: seed, start, board choice, the drop button and the keys. Knows no socket, no canvas.

import { readBoardName } from "./boards.js";
import { byId, make } from "./dom.js";
import { readSeed } from "./seed.js";
import { StartField } from "./start-field.js";

const FEWEST_ROWS = 8;
const MOST_ROWS = 16;

/**
 * @typedef {object} ControlsListener
 * @property {(ask: {seed: string | null, x: number | null}) => void} onDrop valid as far as known
 * @property {(choice: import("./boards.js").Choice) => void} onBoard
 * @property {() => void} onAim
 */

/** The form fields and keys of the live table. */
export class Controls {
  /** @param {ControlsListener} listener */
  constructor(listener) {
    this.listener = listener;
    this.seed = byId("seed");
    this.note = byId("seed-note");
    this.hint = this.note.textContent;
    this.boardForm = byId("board-form");
    this.start = new StartField(() => listener.onAim());
    this.#fillRows();
    byId("drop-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.drop(this.start.x);
    });
    this.seed.addEventListener("input", () => this.#checkSeed());
    byId("seed-clear").addEventListener("click", () => this.setSeed(""));
    this.boardForm.addEventListener("change", () => listener.onBoard(this.#choice()));
    this.boardForm.addEventListener("submit", (event) => event.preventDefault());
    document.addEventListener("keydown", (event) => this.#key(event));
  }

  /**
   * Asks for a drop, unless the seed is not one: then says so and sends nothing.
   * @param {number | null} x
   */
  drop(x) {
    const reading = this.#checkSeed();
    if (!reading.ok) {
      this.seed.focus();
      return;
    }
    this.listener.onDrop({ seed: reading.seed, x });
  }

  /** @param {string} text */
  setSeed(text) {
    this.seed.value = text;
    this.#checkSeed();
    this.seed.focus();
  }

  /** @param {string} name @param {any} board @param {number[]} slots */
  setBoard(name, board, slots) {
    const choice = readBoardName(name);
    for (const radio of this.boardForm.elements.kind) radio.checked = radio.value === choice?.kind;
    byId("triangle-only").hidden = choice?.kind !== "triangle";
    if (choice?.kind === "triangle") {
      this.boardForm.elements.rows.value = String(choice.rows);
      this.boardForm.elements.risk.value = choice.risk;
    }
    this.start.setBoard(board, slots);
  }

  #choice() {
    const { kind, rows, risk } = this.boardForm.elements;
    return { kind: kind.value || "triangle", rows: Number(rows.value), risk: risk.value };
  }

  #checkSeed() {
    const reading = readSeed(this.seed.value);
    const message = reading.ok ? this.hint : reading.message;
    // Only a change is written, so that a screen reader is told once.
    if (this.note.textContent !== message) this.note.textContent = message;
    this.note.classList.toggle("note-bad", !reading.ok);
    this.note.setAttribute("role", reading.ok ? "note" : "alert");
    this.seed.setAttribute("aria-invalid", String(!reading.ok));
    return reading;
  }

  /** Space drops from anywhere that has no use of its own for it. */
  #key(event) {
    if (event.key !== " " || event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.target.closest("input:not([type=range]), select, button, a, summary")) return;
    event.preventDefault();
    if (!event.repeat) this.drop(this.start.x);
  }

  #fillRows() {
    const rows = byId("rows");
    for (let count = FEWEST_ROWS; count <= MOST_ROWS; count += 1) {
      rows.append(make("option", { value: String(count) }, String(count)));
    }
    rows.value = String(MOST_ROWS);
  }
}
