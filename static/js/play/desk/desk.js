// The desk: stake, balls, speed, auto-drop, seed and the DROP button, with their keys.

import { readSeed } from "../../model/seed.js";
import { t } from "../../texts/text.js";
import { byId, check, isWithin, onChoice, onClick, onSubmit, radiosOf, radioValue } from "../../util/dom.js";
import { plain } from "../../util/format.js";
import { allowedStake, LEAST_STAKE, mostCredits, readAmount, readStake, typed } from "./amounts.js";

/** @import { Pace } from "../../model/table/pace.js" */
/** @import { Game } from "../game.js" */

const PRACTICE = /** @type {const} */ ({
  seed: "practice.seed", colliding: "practice.colliding", offline: "practice.offline", unsealed: "practice.unsealed",
});
const AUTO = "auto";
const AUTO_KEY = "plinko.auto.1";
// Elements where Space has a use already: it types a space, moves a slider or presses the focused button.
const OWN_SPACE = "button, a, select, summary, textarea, dialog, input:not([type=radio]:checked)";

/** The form in which the player sets and makes drops. */
export class Desk {
  /** @param {Game} game */
  constructor(game) {
    this.game = game;
    this.stake = byId("stake", HTMLInputElement);
    this.seed = byId("seed", HTMLInputElement);
    this.note = byId("seed-note");
    this.hint = this.note.textContent ?? "";
    this.drop = byId("drop", HTMLButtonElement);
    this.label = byId("drop-label");
    this.auto = ["auto-count", "auto-rate", "auto-win", "auto-loss"].map((id) =>
      /** @type {HTMLInputElement | HTMLSelectElement} */ (byId(id)));
    this.stake.value = typed(game.choice.stake);
    check("balls", game.choice.balls);
    check("pace", game.choice.pace);
    this.#listen();
    this.#keepAuto();
    for (const kind of /** @type {const} */ (["choice", "room", "run", "table"])) game.on(kind, () => this.#show());
    // In a room with a draw nobody chooses a seed.
    game.on("table", ({ hello: { draw } }) => {
      document.documentElement.toggleAttribute("data-draw", draw !== undefined);
      if (draw) this.#setSeed("");
    });
    this.#show();
    const asked = new URLSearchParams(window.location.search).get("seed");
    if (asked !== null) this.#setSeed(asked);
  }

  #listen() {
    const { game, stake } = this;
    onSubmit("drop-form", () => this.#push());
    stake.addEventListener("change", () => this.#readStake());
    stake.addEventListener("focus", () => stake.select());
    stake.addEventListener("keydown", (event) => {
      if (event.key === "Enter" && !this.#readStake()) event.preventDefault();
      if (event.key === " ") event.preventDefault(); // the text is selected: a space would replace it
    });
    /** @param {string} id @param {() => number} value */
    const step = (id, value) => onClick(id, () => {
      this.#readStake();
      this.#setStake(allowedStake(value(), this.#most));
    });
    step("stake-half", () => game.choice.stake / 2);
    step("stake-double", () => game.choice.stake * 2);
    step("stake-max", () => game.account.balance / game.choice.balls);
    for (const name of ["balls", "pace"]) {
      onChoice(name, () => {
        const balls = radioValue("balls");
        const pace = /** @type {Pace} */ (radioValue("pace"));
        game.choose({ pace, ...(balls !== AUTO && { balls: Number(balls) }) });
      });
    }
    this.seed.addEventListener("input", () => this.#readSeed());
    for (const id of ["seed-clear", "practice-end"]) onClick(id, () => this.#setSeed(""));
    document.addEventListener("keydown", (event) => this.#key(event));
  }

  /** The DROP button: drops, starts the auto-drop, or stops the running one. */
  #push() {
    const { game } = this;
    if (game.auto) game.stop("player");
    else if (!this.#readSeed()) {
      game.tell("choice", null);
      this.seed.focus();
    } else if (radioValue("balls") !== AUTO) game.drop();
    else {
      const [count, rate, win, loss] = this.auto.map((field) => {
        const value = readAmount(field.value);
        if (!value && field instanceof HTMLInputElement) field.value = "";
        return value || Number.POSITIVE_INFINITY;
      });
      game.startAuto({ rate, count, win, loss });
    }
  }

  /** @param {string} text */
  #setSeed(text) {
    this.seed.value = text;
    this.#readSeed();
  }

  /** The largest stake at this table, in credits. */
  get #most() {
    return mostCredits(this.game.room.hello?.board.bins.multipliers ?? null);
  }

  /** Keeps the last valid stake if the new one is not, and says which are. @returns {boolean} whether it is valid */
  #readStake() {
    const stake = readStake(this.stake.value, this.#most);
    if (stake === null) this.game.say(t("play.stake-range", { least: plain(LEAST_STAKE), most: plain(this.#most) }));
    this.#setStake(stake ?? this.game.choice.stake);
    return stake !== null;
  }

  /** @param {number} stake */
  #setStake(stake) {
    this.stake.value = typed(stake);
    this.game.choose({ stake });
  }

  /** @returns {boolean} whether the field has a valid seed, or is empty */
  #readSeed() {
    const reading = readSeed(this.seed.value);
    const message = reading.ok ? this.hint : reading.message;
    // Only a change is written, so that a screen reader reads it once.
    if (this.note.textContent !== message) this.note.textContent = message;
    this.note.dataset.tone = reading.ok ? "" : "bad";
    this.note.setAttribute("role", reading.ok ? "note" : "alert");
    this.seed.setAttribute("aria-invalid", String(!reading.ok));
    if (reading.ok && reading.seed !== this.game.choice.seed) this.game.choose({ seed: reading.seed });
    return reading.ok;
  }

  #keepAuto() {
    const kept = JSON.parse(this.game.storage.getItem(AUTO_KEY) ?? "{}");
    for (const field of this.auto) {
      field.value = kept[field.id] ?? field.value;
      field.addEventListener("change", () => {
        kept[field.id] = field.value;
        this.game.storage.setItem(AUTO_KEY, JSON.stringify(kept));
      });
    }
  }

  #show() {
    const { auto, practice, room } = this.game;
    const { dataset } = document.documentElement;
    if (practice) dataset.practice = practice;
    else delete dataset.practice;
    byId("auto-panel").hidden = radioValue("balls") !== AUTO;
    byId("practice-note").textContent = practice ? t(PRACTICE[practice]) : "";
    byId("practice-end").hidden = practice !== "seed";
    for (const radio of radiosOf("pace")) radio.disabled = room.table !== null && !room.table.solve;
    this.drop.disabled = room.state === "closed" && !room.table;
    const words = this.#words(auto, practice !== null);
    if (this.label.textContent !== words) this.label.textContent = words;
    this.drop.dataset.running = String(auto !== null);
  }

  /** @param {{left: number} | null} auto @param {boolean} practice */
  #words(auto, practice) {
    if (auto) return Number.isFinite(auto.left) ? t("auto.stop-left", { n: auto.left }) : t("auto.stop");
    if (practice) return t("practice.drop");
    return radioValue("balls") === AUTO ? t("auto.start") : t("word.drop");
  }

  /** Space drops, unless the focused element uses it itself. @param {KeyboardEvent} event */
  #key(event) {
    if (event.key !== " " || event.ctrlKey || event.altKey || event.metaKey) return;
    if (isWithin(event, OWN_SPACE)) return;
    event.preventDefault();
    if (!event.repeat) this.#push();
  }
}
