// The impacts of a drop as a table to choose from, the chosen one in numbers, and all as CSV.

import { byId, make } from "../util/dom.js";
import { figure, prefixed } from "../util/scale.js";
import { impactOf } from "../model/impact.js";
import { fillFacts, saveFile } from "../board/page.js";

const COLUMNS = ["number", "t", "what", "x", "y", "normal_x", "normal_y", "impulse_x", "impulse_y",
  "impulse_normal", "impulse_tangential", "vx_before", "vy_before", "omega_before", "vx_after",
  "vy_after", "omega_after", "energy_lost"];

/** @typedef {import("../model/impact.js").Impact} Impact */

/** The table; `onChoose(index)` tells which impact is wanted. */
export class ImpactList {
  #rows = [];
  #now = -1;
  #chosen = -1;

  /** @param {(index: number) => void} onChoose */
  constructor(onChoose) {
    this.onChoose = onChoose;
    byId("save-table").addEventListener("click", () => this.#save());
  }

  /** @param {import("./replay.js").Replay} replay */
  load(replay) {
    this.replay = replay;
    /** @type {Impact[]} */
    this.impacts = replay.motion.events.map((event) => impactOf(replay.board, event));
    this.strongest = Math.max(...this.impacts.map(({ impulse }) => Math.hypot(impulse.x, impulse.y)));
    this.units = {
      impulse: prefixed(this.strongest, "N s"),
      energy: prefixed(Math.max(...this.impacts.map(({ lost }) => Math.abs(lost))), "J"),
    };
    byId("impulse-unit").textContent = `, ${this.units.impulse.unit}`;
    this.#rows = this.impacts.map((impact, i) => this.#row(impact, i));
    byId("impacts").replaceChildren(...this.#rows);
    this.choose(-1);
  }

  /** @param {number} index impact that is the last to have happened, -1 for none yet */
  follow(index) {
    if (index === this.#now) return;
    if (this.#now >= 0) delete this.#rows[this.#now].dataset.now;
    this.#now = index;
    if (index < 0) return;
    const row = this.#rows[index];
    row.dataset.now = "true";
    const box = row.closest(".scroll");
    const head = box.querySelector("thead").offsetHeight;
    // Within its own box: the page itself must not jump.
    if (row.offsetTop < box.scrollTop + head) box.scrollTop = row.offsetTop - head;
    const below = row.offsetTop + row.offsetHeight - box.clientHeight;
    if (below > box.scrollTop) box.scrollTop = below;
  }

  /** @param {number} index the impact shown in numbers, -1 for none */
  choose(index) {
    if (this.#chosen >= 0) this.#button(this.#chosen).setAttribute("aria-pressed", "false");
    this.#chosen = index;
    if (index >= 0) this.#button(index).setAttribute("aria-pressed", "true");
    fillFacts(byId("impact-facts"), index >= 0 ? this.#facts(index) : [
      ["Chosen", "none: choose one below or on the board"],
    ]);
  }

  get chosen() {
    return this.#chosen;
  }

  #button(index) {
    return this.#rows[index].querySelector("button");
  }

  #row(impact, i) {
    const button = make("button", { class: "impact", type: "button", "aria-pressed": "false" });
    button.setAttribute("aria-label", `Impact ${i + 1}, ${impact.what}`);
    button.append(String(i + 1));
    const size = Math.hypot(impact.impulse.x, impact.impulse.y);
    const row = make("tr", {},
      make("td", {}, button),
      make("td", {}, impact.t.toFixed(3)),
      make("td", {}, impact.what),
      make("td", {}, impact.normal ? `${degrees(impact.normal)}°` : "–"),
      make("td", {}, impact.normal ? figure(size * this.units.impulse.per) : "–"));
    row.addEventListener("click", () => this.onChoose(i));
    return row;
  }

  #facts(i) {
    const { normal, impulse, along, across, approach, lost, share, what, t } = this.impacts[i];
    const { before, after } = this.replay.motion.events[i];
    const rows = [["Impact", `${i + 1} of ${this.impacts.length}: ${what}`], ["Time", `${t} s`]];
    if (normal) {
      const push = this.#inUnit("impulse");
      rows.push(
        ["Normal", [swatch("normal"), `${degrees(normal)}° (${figure(normal.x)}, ${figure(normal.y)})`]],
        ["Impulse", [swatch("impulse"), push(Math.hypot(impulse.x, impulse.y))]],
        ["of it normal", `${push(along)} at ${figure(approach)} m/s`],
        ["of it friction", push(across)],
      );
    }
    rows.push(
      ["Speed", `${figure(speed(before))} → ${figure(speed(after))} m/s`],
      ["Spin", `${figure(before.omega)} → ${figure(after.omega)} rad/s`],
    );
    const percent = (100 * share).toFixed(1);
    if (normal) rows.push(["Energy lost", `${this.#inUnit("energy")(lost)}, ${percent} %`]);
    return rows;
  }

  #inUnit(name) {
    const { unit, per } = this.units[name];
    return (value) => `${figure(value * per)} ${unit}`;
  }

  #save() {
    const lines = this.impacts.map((impact, i) => {
      const { before, after } = this.replay.motion.events[i];
      const { normal, impulse } = impact;
      return [i + 1, impact.t, impact.what, after.x, after.y, normal?.x ?? "", normal?.y ?? "",
        impulse.x, impulse.y, impact.along, impact.across, before.vx, before.vy, before.omega,
        after.vx, after.vy, after.omega, impact.lost].join(",");
    });
    const { record } = this.replay;
    const text = [COLUMNS.join(","), ...lines, ""].join("\n");
    saveFile(`impacts-${this.replay.board.name}-${record.seed}.csv`, text, "text/csv");
  }
}

/** Angle of a direction as in a textbook: 0 to the right, 90 up. */
function degrees({ x, y }) {
  return String(Math.round((Math.atan2(-y, x) * 180) / Math.PI)).replace("-", "−");
}

function speed({ vx, vy }) {
  return Math.hypot(vx, vy);
}

function swatch(name) {
  return make("span", { class: `swatch swatch-${name}`, "aria-hidden": "true" });
}
