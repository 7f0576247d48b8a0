// The table of a drop's impacts, the figures of the chosen one, and the table as a CSV file.

import { impactOf } from "../model/impact.js";
import { t } from "../texts/text.js";
import { byId, fillFacts, make, onClick, parentOf } from "../util/dom.js";
import { saveFile } from "../util/file.js";
import { fixed, percent } from "../util/format.js";
import { figure, prefixed } from "../util/scale.js";

/** @import { Impact } from "../model/impact.js" */
/** @import { Replay } from "./replay.js" */
/** @import { Point } from "../model/board.js" */
/** @import { State } from "../model/motion/flight.js" */
/** @import { Fact } from "../util/dom.js" */

const COLUMNS = ["number", "t", "what", "x", "y", "normal_x", "normal_y", "impulse_x", "impulse_y",
  "impulse_normal", "impulse_tangential", "vx_before", "vy_before", "omega_before", "vx_after",
  "vy_after", "omega_after", "energy_lost"];

/** The table; `onChoose(index)` is called when the visitor chooses an impact. */
export class ImpactList {
  /** Index of the impact whose figures are shown; -1 for none. */
  chosen = -1;
  #now = -1;

  /** @param {Replay} replay @param {(index: number) => void} onChoose */
  constructor(replay, onChoose) {
    this.replay = replay;
    this.onChoose = onChoose;
    this.impacts = replay.motion.events.map((event) => impactOf(replay.board, event));
    /** The largest impulse of the drop, N s. */
    this.strongest = Math.max(...this.impacts.map(({ impulse }) => Math.hypot(impulse.x, impulse.y)));
    this.units = {
      impulse: prefixed(this.strongest, "N s"),
      energy: prefixed(Math.max(...this.impacts.map(({ lost }) => Math.abs(lost))), "J"),
    };
    byId("impulse-unit").textContent = `, ${this.units.impulse.unit}`;
    this.rows = this.impacts.map((impact, i) => this.#row(impact, i));
    byId("impacts").replaceChildren(...this.rows.map(({ row }) => row));
    onClick("save-table", () => this.#save());
    this.door = byId("curious", HTMLDetailsElement);
    this.door.addEventListener("toggle", () => this.#scroll());
    this.choose(-1);
  }

  /** Highlights an impact and scrolls to it. @param {number} index the latest impact, -1 for none yet */
  follow(index) {
    if (index === this.#now) return;
    if (this.#now >= 0) delete this.rows[this.#now].row.dataset.now;
    this.#now = index;
    if (index < 0) return;
    this.rows[index].row.dataset.now = "true";
    this.#scroll();
  }

  /** Behind the closed door nothing is scrolled: the browser would lay out all rows. */
  #scroll() {
    if (this.#now < 0 || !this.door.open) return;
    const { row } = this.rows[this.#now];
    const table = parentOf(parentOf(row));
    const box = parentOf(table);
    const head = table.querySelector("thead")?.offsetHeight ?? 0;
    // Scrolls only the table's box; scrollIntoView would scroll the page too.
    if (row.offsetTop < box.scrollTop + head) box.scrollTop = row.offsetTop - head;
    const below = row.offsetTop + row.offsetHeight - box.clientHeight;
    if (below > box.scrollTop) box.scrollTop = below;
  }

  /** @param {number} index the impact whose figures to show, -1 for none */
  choose(index) {
    if (this.chosen >= 0) this.rows[this.chosen].button.setAttribute("aria-pressed", "false");
    this.chosen = index;
    if (index >= 0) this.rows[index].button.setAttribute("aria-pressed", "true");
    fillFacts(byId("impact-facts"), index >= 0 ? this.#facts(index) : [["fact.chosen", t("fact.chosen-none")]]);
  }

  /**
   * Marks the first impacts as verified, one in each frame.
   * @param {number} count
   */
  async turnGreen(count) {
    for (const { row } of this.rows) delete row.dataset.verified;
    for (const { row } of this.rows.slice(0, count)) {
      row.dataset.verified = "true";
      await new Promise(requestAnimationFrame);
    }
  }

  /** @param {Impact} impact @param {number} i */
  #row(impact, i) {
    const { t: time, told, normal, impulse } = impact;
    const name = t("replay.impact-button", { n: i + 1, what: told });
    const button = make("button", { class: "impact", type: "button", "aria-pressed": "false", "aria-label": name }, String(i + 1));
    const size = Math.hypot(impulse.x, impulse.y);
    const cells = [
      button, fixed(time, 3), told, normal ? `${degrees(normal)}°` : "–",
      normal ? figure(size * this.units.impulse.per) : "–",
    ];
    const row = make("tr", {}, ...cells.map((cell) => make("td", {}, cell)));
    row.addEventListener("click", () => this.onChoose(i));
    return { row, button };
  }

  /** @param {number} i */
  #facts(i) {
    const { normal, impulse, along, across, approach, lost, share, told, t: time } = this.impacts[i];
    const { before, after } = this.replay.motion.events[i];
    /** @type {Fact[]} */
    const rows = [
      ["fact.impact", t("fact.impact-of", { n: i + 1, all: this.impacts.length, what: told })],
      ["fact.time", `${time} s`],
    ];
    if (normal) {
      const push = this.#inUnit("impulse");
      rows.push(
        ["fact.normal", [swatch("normal"), `${degrees(normal)}° (${figure(normal.x)}, ${figure(normal.y)})`]],
        ["fact.impulse", [swatch("impulse"), push(Math.hypot(impulse.x, impulse.y))]],
        ["fact.of-it-normal", t("fact.of-it-normal-at", { push: push(along), speed: figure(approach) })],
        ["fact.of-it-friction", push(across)],
      );
    }
    rows.push(
      ["fact.speed", `${figure(speed(before))} → ${figure(speed(after))} m/s`],
      ["fact.spin", `${figure(before.omega)} → ${figure(after.omega)} rad/s`],
    );
    if (normal) rows.push(["fact.energy-lost", `${this.#inUnit("energy")(lost)}, ${percent(share)}`]);
    return rows;
  }

  /** @param {"impulse" | "energy"} name */
  #inUnit(name) {
    const { unit, per } = this.units[name];
    return (/** @type {number} */ value) => `${figure(value * per)} ${unit}`;
  }

  #save() {
    const { board, record, motion } = this.replay;
    const lines = this.impacts.map((impact, i) => {
      const { before, after } = motion.events[i];
      const { normal, impulse } = impact;
      return [i + 1, impact.t, impact.what, after.x, after.y, normal?.x ?? "", normal?.y ?? "",
        impulse.x, impulse.y, impact.along, impact.across, before.vx, before.vy, before.omega,
        after.vx, after.vy, after.omega, impact.lost].join(",");
    });
    const text = [COLUMNS.join(","), ...lines, ""].join("\n");
    saveFile(`impacts-${board.name}-${record.seed}.csv`, text, "text/csv");
  }
}

/** Angle of a direction in degrees: 0 to the right, 90 up. @param {Point} point */
function degrees({ x, y }) {
  return String(Math.round((Math.atan2(-y, x) * 180) / Math.PI)).replace("-", "−");
}

/** @param {State} state */
function speed({ vx, vy }) {
  return Math.hypot(vx, vy);
}

/** @param {string} name */
function swatch(name) {
  return make("span", { class: `swatch swatch-${name}`, "aria-hidden": "true" });
}
