// The desk: stake, balls, speed, auto-drop, seed and the DROP button.
//
// A value counts once its field is left, or at a press of DROP. While one is invalid, its field is marked, the fault is
// shown, and nothing is dropped.

import { readSeed } from "../../model/seed.js";
import { t } from "../../texts/text.js";
import { byId, check, onChoice, onClick, onSubmit, putMessage, radiosOf, radioValue } from "../../util/dom.js";
import { amount, plain } from "../../util/format.js";
import { isRecord, readStored } from "../../util/stored.js";
import {
  allowedStake, FACTORS, faultOf, LEAST_STAKE, MOST_BALLS, readAmount, readCount, readFactor, readStake, typed,
} from "./amounts.js";
import { onKey, onSpace } from "./keys.js";

/** @import { Pace } from "../../model/table/pace.js" */
/** @import { Game } from "../game.js" */
/** @import { Reaction, Step } from "../drop-series.js" */

/** @typedef {HTMLInputElement | HTMLSelectElement} Field */

const PRACTICE = /** @type {const} */ ({
  seed: "practice.seed", aim: "practice.aim", colliding: "practice.colliding", unsolved: "practice.unsolved",
  offline: "practice.offline", unsealed: "practice.unsealed",
});
const AUTO = "auto";
const TIMES = "times"; // the reaction that has a factor
const AUTO_KEY = "plinko.auto.1";
const AUTO_FIELDS = [
  "auto-count", "auto-rate", "auto-win", "auto-loss", "auto-on-win", "auto-win-factor", "auto-on-loss",
  "auto-loss-factor",
];

/** The form in which the player sets and makes drops. */
export class Desk {
  /** The values that count, by field. @type {Map<Field, string>} */
  #values = new Map();

  /** @param {Game} game */
  constructor(game) {
    this.game = game;
    this.stake = byId("stake", HTMLInputElement);
    this.seed = byId("seed", HTMLInputElement);
    this.note = byId("seed-note");
    this.hint = this.note.textContent ?? "";
    this.drop = byId("drop", HTMLButtonElement);
    this.label = byId("drop-label");
    this.auto = AUTO_FIELDS.map((id) => /** @type {Field} */ (byId(id)));
    this.stake.value = typed(game.choice.stake);
    check("balls", game.choice.balls);
    check("pace", game.choice.pace);
    this.#keepAuto();
    for (const field of [this.stake, ...this.auto]) this.#values.set(field, field.value);
    this.#listen();
    for (const kind of /** @type {const} */ (["choice", "room", "run", "table"])) game.on(kind, () => this.#show());
    game.on("faulty", () => this.#point());
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
    stake.addEventListener("focus", () => stake.select());
    for (const field of [stake, ...this.auto]) {
      field.addEventListener("change", () => this.#take(field));
      // A marked field is read at once, so that the mark goes with the fault.
      field.addEventListener("input", () => { if (field.getAttribute("aria-invalid") === "true") this.#take(field); });
    }
    onClick("stake-half", () => this.#scale(0.5));
    onClick("stake-double", () => this.#scale(2));
    onClick("stake-max", () => this.#setStake(this.#affordable));
    for (const name of ["balls", "pace"]) {
      onChoice(name, () => {
        const balls = radioValue("balls");
        const pace = /** @type {Pace} */ (radioValue("pace"));
        game.choose({ pace, ...(balls !== AUTO && { balls: Number(balls) }) });
      });
    }
    this.seed.addEventListener("input", () => this.#readSeed());
    for (const id of ["seed-clear", "practice-end"]) onClick(id, () => this.#setSeed(""));
    onSpace(() => this.#push());
    onKey(["-", "−"], () => { if (!game.practice) this.#scale(0.5); });
    onKey(["+", "="], () => { if (!game.practice) this.#scale(2); });
  }

  /** The DROP button: drops, starts the auto-drop, or stops the running one. */
  #push() {
    const { game } = this;
    if (game.auto) {
      game.stop("player");
      return;
    }
    for (const field of [this.stake, ...this.auto]) this.#take(field);
    if (!this.#readSeed()) {
      game.tell("choice", null);
      this.seed.focus();
    } else if (radioValue("balls") !== AUTO) game.drop();
    else {
      const [count, rate, win, loss, onWin, winFactor, onLoss, lossFactor] = this.auto.map(({ value }) => value);
      game.startAuto(Number(rate), readCount(count) ?? Number.POSITIVE_INFINITY, {
        win: readAmount(win) ?? Number.POSITIVE_INFINITY, loss: readAmount(loss) ?? Number.POSITIVE_INFINITY,
        onWin: stepOf(onWin, winFactor), onLoss: stepOf(onLoss, lossFactor),
      });
    }
  }

  /** Lets a field's value count. @param {Field} field */
  #take(field) {
    this.#values.set(field, field.value);
    const stake = field === this.stake ? readStake(field.value, this.game.mostStake) : null;
    if (stake !== null) this.#setStake(stake);
    else this.#show();
  }

  /** @param {string} text */
  #setSeed(text) {
    this.seed.value = text;
    this.#readSeed();
  }

  /** @param {number} factor of the last valid stake */
  #scale(factor) {
    this.#setStake(Math.min(this.game.choice.stake * factor, this.#affordable));
  }

  /** The stake at which the balance lasts for one press of DROP, credits. */
  get #affordable() {
    const { account, choice } = this.game;
    return account.balance / (radioValue("balls") === AUTO ? 1 : choice.balls);
  }

  /** @param {number} wanted the nearest stake that this table takes is set */
  #setStake(wanted) {
    const stake = allowedStake(wanted, this.game.mostStake);
    this.stake.value = typed(stake);
    this.#values.set(this.stake, this.stake.value);
    this.game.choose({ stake });
  }

  /** @param {Field} field @returns {string} what is wrong with its value; "" if nothing is, or if it is not used now */
  #fault(field) {
    const { game } = this;
    const text = (this.#values.get(field) ?? "").trim();
    const least = plain(LEAST_STAKE);
    if (field === this.stake) {
      if (game.practice || readStake(text, game.mostStake) !== null) return "";
      return faultOf(text, t("play.stake-range", { least, most: plain(game.mostStake) }));
    }
    if (radioValue("balls") !== AUTO) return "";
    const [count, , win, loss, onWin, winFactor, onLoss, lossFactor] = this.auto;
    if (field === count && text && readCount(text) === null) return faultOf(text, t("fault.count", { most: plain(MOST_BALLS) }));
    if (game.practice) return ""; // the other fields are about stakes
    if ((field === win || field === loss) && text && !readAmount(text)) return faultOf(text, t("fault.limit"));
    if (field === loss && text && Number(readAmount(text)) < game.choice.stake) {
      return t("fault.loss", { typed: text, stake: amount(game.choice.stake) });
    }
    const used = (field === winFactor && onWin.value === TIMES) || (field === lossFactor && onLoss.value === TIMES);
    if (!used || readFactor(text) !== null) return "";
    return faultOf(text, t("fault.factor", { least: plain(FACTORS.least), most: plain(FACTORS.most) }));
  }

  /** Marks invalid fields, and shows the first one's fault. */
  #mark() {
    let first = "";
    for (const field of [this.stake, ...this.auto]) {
      const fault = this.#fault(field);
      field.setAttribute("aria-invalid", String(fault !== ""));
      first ||= fault;
    }
    const shown = byId("fault");
    if (shown.textContent !== first) putMessage(shown, first); // so that a screen reader reads it once
    shown.hidden = first === "";
    const seed = readSeed(this.seed.value); // its fault stands below its field
    const fault = first || (seed.ok ? "" : seed.message);
    if (fault !== this.game.choice.fault) this.game.choose({ fault });
  }

  /** Leads to the first invalid field, and says again what is wrong with it. */
  #point() {
    [this.stake, ...this.auto, this.seed].find((field) => field.getAttribute("aria-invalid") === "true")?.focus();
    byId("fault").textContent = "";
    this.#mark();
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
    else this.#mark();
    return reading.ok;
  }

  #keepAuto() {
    const kept = readStored(this.game.storage, AUTO_KEY, isRecord) ?? {};
    for (const field of this.auto) {
      const value = kept[field.id];
      if (typeof value === "string") field.value = value;
      if (field instanceof HTMLSelectElement && field.selectedIndex < 0) field.selectedIndex = 0;
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
    byId("practice-end").hidden = practice !== "seed" && practice !== "aim";
    for (const radio of radiosOf("pace")) radio.disabled = room.table !== null && !room.table.solve;
    for (const side of ["win", "loss"]) {
      byId(`auto-${side}-factor`).hidden = byId(`auto-on-${side}`, HTMLSelectElement).value !== TIMES;
    }
    for (const field of this.auto) field.disabled = auto !== null;
    this.drop.disabled = (room.state === "closed" && !room.table) || this.game.moving;
    this.#mark();
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
}

/** @param {string} how @param {string} factor as typed @returns {Step} */
function stepOf(how, factor) {
  return { how: /** @type {Reaction} */ (how), factor: readFactor(factor) ?? 1 };
}
