// The desk: stake, balls, speed, auto-drop, seed and DROP; and the keys that play.

import { readSeed } from "../../model/seed.js";
import { t } from "../../texts/text.js";
import { byId, isWithin, radiosOf, radioValue } from "../../util/dom.js";
import { plain } from "../../util/format.js";
import { allowedStake, LEAST_STAKE, MOST_STAKE, readAmount, readStake, typed } from "./amounts.js";

/** @import { Pace } from "../../model/table/pace.js" */
/** @import { Game } from "../game.js" */

const PRACTICE = /** @type {const} */ ({
  seed: "practice.seed", colliding: "practice.colliding", offline: "practice.offline", unsealed: "practice.unsealed",
});
const AUTO = "auto";
const AUTO_KEY = "plinko.auto.1";
const AUTO_FIELDS = ["auto-count", "auto-rate", "auto-win", "auto-loss"];
// Where Space writes a space, moves something, or presses what has the focus.
const OWN_SPACE = "button, a, select, summary, textarea, dialog, input:not([type=radio]:checked)";

/** Shows what is set, and sets it. */
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
    this.#listen();
    this.#keepAuto();
    game.on("choice", () => this.#show());
    game.on("room", () => this.#show());
    game.on("run", () => this.#show());
    game.on("table", () => this.#show());
    this.#showChoice();
    this.#show();
    const asked = new URLSearchParams(window.location.search).get("seed");
    if (asked !== null) this.setSeed(asked);
  }

  #listen() {
    const { game, stake } = this;
    byId("drop-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.push();
    });
    stake.addEventListener("change", () => this.#readStake());
    stake.addEventListener("focus", () => stake.select());
    stake.addEventListener("keydown", (event) => {
      if (event.key === "Enter" && !this.#readStake()) event.preventDefault();
      if (event.key === " ") event.preventDefault(); // it would empty the field, which is selected
    });
    /** @type {[string, () => number][]} */
    const keys = [
      ["stake-half", () => game.choice.stake / 2],
      ["stake-double", () => game.choice.stake * 2],
      ["stake-max", () => game.account.balance / game.choice.balls],
    ];
    for (const [id, value] of keys) {
      byId(id).addEventListener("click", () => {
        this.#readStake();
        this.#setStake(allowedStake(value()));
      });
    }
    for (const radio of [...radiosOf("balls"), ...radiosOf("pace")]) {
      radio.addEventListener("change", () => this.#choose());
    }
    this.seed.addEventListener("input", () => this.#readSeed());
    byId("seed-clear").addEventListener("click", () => this.setSeed(""));
    byId("practice-end").addEventListener("click", () => this.setSeed(""));
    document.addEventListener("keydown", (event) => this.#key(event));
  }

  /** Drops what is set; a running auto-drop ends instead. */
  push() {
    const { game } = this;
    if (game.auto) {
      game.stop("player");
      return;
    }
    if (!this.#readSeed()) {
      this.game.tell("choice", null);
      this.seed.focus();
      return;
    }
    this.#drop();
  }

  #drop() {
    if (radioValue("balls") !== AUTO) {
      this.game.drop();
      return;
    }
    const [count, rate, win, loss] = AUTO_FIELDS.map((id) => {
      const field = /** @type {HTMLInputElement | HTMLSelectElement} */ (byId(id));
      const value = readAmount(field.value);
      if (!value && field instanceof HTMLInputElement) field.value = "";
      return value || Number.POSITIVE_INFINITY;
    });
    this.game.startAuto({ rate, count, win, loss });
  }

  /** @param {string} text */
  setSeed(text) {
    this.seed.value = text;
    this.#readSeed();
  }

  /** A bad stake leaves the last good one, and says what a stake may be. @returns {boolean} */
  #readStake() {
    const stake = readStake(this.stake.value);
    if (stake === null) this.game.say(t("play.stake-range", { least: plain(LEAST_STAKE), most: plain(MOST_STAKE) }));
    this.#setStake(stake ?? this.game.choice.stake);
    return stake !== null;
  }

  /** @param {number} stake */
  #setStake(stake) {
    this.stake.value = typed(stake);
    this.game.choose({ stake });
  }

  #choose() {
    const balls = radioValue("balls");
    this.game.choose({
      pace: /** @type {Pace} */ (radioValue("pace")), ...(balls !== AUTO && { balls: Number(balls) }),
    });
  }

  /** @returns {boolean} whether it is a seed, or none */
  #readSeed() {
    const reading = readSeed(this.seed.value);
    const message = reading.ok ? this.hint : reading.message;
    // Only a change is written, so that a screen reader is told once.
    if (this.note.textContent !== message) this.note.textContent = message;
    this.note.dataset.tone = reading.ok ? "" : "bad";
    this.note.setAttribute("role", reading.ok ? "note" : "alert");
    this.seed.setAttribute("aria-invalid", String(!reading.ok));
    if (reading.ok && reading.seed !== this.game.choice.seed) this.game.choose({ seed: reading.seed });
    return reading.ok;
  }

  #keepAuto() {
    const kept = JSON.parse(this.game.storage.getItem(AUTO_KEY) ?? "{}");
    for (const id of AUTO_FIELDS) {
      const field = /** @type {HTMLInputElement | HTMLSelectElement} */ (byId(id));
      if (kept[id] !== undefined) field.value = kept[id];
      field.addEventListener("change", () => {
        kept[id] = field.value;
        this.game.storage.setItem(AUTO_KEY, JSON.stringify(kept));
      });
    }
  }

  #showChoice() {
    const { stake, balls, pace } = this.game.choice;
    this.stake.value = typed(stake);
    for (const radio of radiosOf("balls")) radio.checked = radio.value === String(balls);
    for (const radio of radiosOf("pace")) radio.checked = radio.value === pace;
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

  /**
   * Space drops where nothing that has the focus makes use of it.
   * @param {KeyboardEvent} event
   */
  #key(event) {
    if (event.key !== " " || event.ctrlKey || event.altKey || event.metaKey) return;
    if (isWithin(event, OWN_SPACE)) return;
    event.preventDefault();
    if (!event.repeat) this.push();
  }
}
