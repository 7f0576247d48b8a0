// The desk: balls, stake, seed, start, board choice, auto-drop and the keys. Knows no socket, no canvas.

import { readBoardName } from "../../model/presets.js";
import { readSeed, seedAfter } from "../../model/seed.js";
import { GRAVITY, OWN, readWorldName, RESTITUTION, restitutionOf, tableOf, worldWords } from "../../model/worlds.js";
import { PACES } from "../../model/table/pace.js";
import { t } from "../../texts/text.js";
import { byId, fieldOf, isWithin, make, radiosOf, radioValue } from "../../util/dom.js";
import { plain } from "../../util/format.js";
import { figure } from "../../util/scale.js";
import { KeptAims } from "./kept-aims.js";
import { StartField } from "./start-field.js";
import { Tables } from "./tables.js";

/** @import { Board } from "../../model/board.js" */
/** @import { Pace } from "../../model/table/pace.js" */
/** @import { Choice } from "../../model/presets.js" */
/** @import { World } from "../../model/worlds.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Limits } from "./dropper.js" */

const FEWEST_ROWS = 8;
const MOST_ROWS = 16;
// Where a space is a space, or closes a sheet.
const TYPED_INTO = "input:not([type=range], [type=radio], [type=checkbox]), textarea, dialog";

/**
 * @typedef {{seed: string | null, aim: number | null, stake: number}} Ask
 * @typedef {Choice & World & {knock: boolean}} TableChoice
 * knock: whether balls knock each other
 *
 * @typedef {object} ControlsListener
 * @property {(count: number, ask: () => Ask) => void} onDrop so many balls; `ask` makes each
 * @property {(rate: number, count: number, ask: () => Ask, limits: Limits) => void} onAuto from now on
 * @property {() => void} onStop
 * @property {(choice: TableChoice) => void} onBoard
 * @property {() => void} onAim
 * @property {() => void} onPace
 * @property {() => void} onSeed the field of the seed is to be seen
 */

/** The form fields and keys of the live table. */
export class Controls {
  #running = false;

  /** @param {Theme} theme @param {ControlsListener} listener */
  constructor(theme, listener) {
    this.listener = listener;
    this.tables = new Tables(theme, (world) => this.#setWorld(world));
    this.seed = byId("seed", HTMLInputElement);
    this.stake = byId("stake", HTMLInputElement);
    this.paces = byId("paces", HTMLFieldSetElement);
    this.note = byId("seed-note");
    this.hint = this.note.textContent ?? "";
    this.boardForm = byId("board-form", HTMLFormElement);
    this.start = new StartField(new KeptAims(window.localStorage), () => listener.onAim());
    this.#fillRows();
    byId("drop-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.drop(this.start.aim);
    });
    byId("auto").addEventListener("click", () => this.#auto());
    this.paces.addEventListener("change", () => listener.onPace());
    this.seed.addEventListener("input", () => this.#checkSeed());
    byId("seed-clear").addEventListener("click", () => this.setSeed(""));
    this.boardForm.addEventListener("change", () => listener.onBoard(this.#choice()));
    this.boardForm.addEventListener("submit", (event) => event.preventDefault());
    document.addEventListener("keydown", (event) => this.#key(event));
    // A button that has the focus would be pressed when Space comes up.
    document.addEventListener("keyup", (event) => {
      if (event.key === " " && !isWithin(event, TYPED_INTO)) event.preventDefault();
    });
  }

  /**
   * Asks for drops, unless a field holds what is no value: then says so and sends nothing.
   * @param {number | null} aim metres
   */
  drop(aim) {
    const ask = this.#asker(aim);
    if (ask) this.listener.onDrop(this.#balls, ask);
  }

  /** @param {string} text */
  setSeed(text) {
    this.seed.value = text;
    this.#checkSeed();
    this.#showSeed();
  }

  /** @param {string} name @param {Board} board @param {number[]} slots */
  setBoard(name, board, slots) {
    this.showChoice(name);
    byId("gravity", HTMLSelectElement).options[0].textContent = t("world.own-gravity", { g: figure(board.gravity) });
    this.start.setBoard(board, slots);
  }

  /** @param {boolean} knock whether balls knock each other at this table */
  showKnocking(knock) {
    fieldOf(this.boardForm, "balls").value = knock ? "knock" : "pass";
  }

  /** @param {string} name of the board that is played */
  showChoice(name) {
    const { preset, gravity, material } = readWorldName(name);
    const choice = readBoardName(preset);
    for (const radio of radiosOf("kind")) radio.checked = radio.value === choice?.kind;
    byId("triangle-only").hidden = choice?.kind !== "triangle";
    byId("world").hidden = choice === null;
    this.#setWorld({ gravity, material });
    this.tables.show(tableOf({ gravity, material }));
    if (choice?.kind === "triangle") {
      fieldOf(this.boardForm, "rows").value = String(choice.rows);
      fieldOf(this.boardForm, "risk").value = choice.risk;
    }
  }

  /** @param {World} world as the two fields of the form are to say */
  #setWorld({ gravity, material }) {
    fieldOf(this.boardForm, "gravity").value = gravity;
    fieldOf(this.boardForm, "material").value = material;
  }

  /** @param {boolean} running @param {number} left drops still to come */
  showAuto(running, left) {
    this.#running = running;
    const button = byId("auto");
    button.setAttribute("aria-pressed", String(running));
    const text = running ? stopWords(left) : t("play.auto-start");
    if (button.textContent !== text) button.textContent = text;
  }

  /** Times as fast as the table's clock that our balls are to fall to the eye. */
  get pace() {
    return PACES[/** @type {Pace} */ (radioValue("pace"))];
  }

  /** @param {boolean} free whether this page knows a ball's way before it has fallen */
  showPace(free) {
    this.paces.disabled = !free;
  }

  get #balls() {
    return Number(fieldOf(byId("drop-form", HTMLFormElement), "balls").value);
  }

  /**
   * What makes one ask after the other, or null when a field is wrong.
   * @param {number | null} aim metres
   * @returns {(() => Ask) | null}
   */
  #asker(aim) {
    const reading = this.#checkSeed();
    if (!reading.ok) {
      this.#showSeed();
      return null;
    }
    if (!this.stake.reportValidity()) return null;
    const stake = Number(this.stake.value);
    let { seed } = reading;
    return () => {
      const ask = { seed, aim, stake };
      if (seed !== null) seed = seedAfter(seed);
      return ask;
    };
  }

  #auto() {
    if (this.#running) {
      this.listener.onStop();
      return;
    }
    const count = byId("auto-count", HTMLInputElement);
    const [win, loss] = ["auto-win", "auto-loss"].map((id) => byId(id, HTMLInputElement));
    const valid = [count, win, loss].every((field) => field.reportValidity());
    const ask = valid ? this.#asker(this.start.aim) : null;
    if (!ask) return;
    const rate = Number(byId("auto-rate", HTMLSelectElement).value);
    this.listener.onAuto(rate, numberOf(count), ask, { win: numberOf(win), loss: numberOf(loss) });
  }

  /** @returns {TableChoice} */
  #choice() {
    const value = (/** @type {string} */ name) => fieldOf(this.boardForm, name).value;
    return {
      kind: /** @type {TableChoice["kind"]} */ (value("kind") || "triangle"),
      rows: Number(value("rows")),
      risk: /** @type {TableChoice["risk"]} */ (value("risk")),
      gravity: value("gravity"), material: value("material"), knock: value("balls") === "knock",
    };
  }

  #showSeed() {
    this.listener.onSeed();
    this.seed.focus();
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

  /**
   * Space drops whatever has the focus but a text field (Enter presses buttons); arrows aim from
   * anywhere that has no use of its own for them.
   * @param {KeyboardEvent} event
   */
  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key === " ") {
      if (isWithin(event, TYPED_INTO)) return;
      event.preventDefault();
      if (!event.repeat) this.drop(this.start.aim);
    } else if (event.key === "ArrowLeft" || event.key === "ArrowRight") {
      if (isWithin(event, "input, select, textarea, dialog")) return;
      event.preventDefault();
      this.start.nudge(event.key === "ArrowLeft" ? -1 : 1, event.shiftKey);
    }
  }

  #fillRows() {
    const rows = byId("rows", HTMLSelectElement);
    for (let count = FEWEST_ROWS; count <= MOST_ROWS; count += 1) {
      rows.append(make("option", { value: String(count) }, String(count)));
    }
    rows.value = String(MOST_ROWS);
    /** @param {string} value @param {...string} parts */
    const option = (value, ...parts) => make("option", { value }, parts.join(" "));
    byId("gravity").append(option(OWN, t("world.own")), ...Object.entries(GRAVITY).map(([name, value]) =>
      option(name, worldWords(name), plain(value))));
    byId("material").append(option(OWN, t("world.own-material")), ...Object.keys(RESTITUTION).map((name) =>
      option(name, worldWords(name), plain(restitutionOf(name)))));
  }
}

/** @param {number} left drops still to come, Infinity without an end */
function stopWords(left) {
  return Number.isFinite(left) ? t("play.auto-stop-left", { n: left }) : t("play.auto-stop");
}

/** @param {HTMLInputElement} field @returns {number} Infinity where it is empty */
function numberOf({ value }) {
  return value === "" ? Number.POSITIVE_INFINITY : Number(value);
}
