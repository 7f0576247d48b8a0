// The measurements in the box: a plot of the energies of the last half minute, and the rest as numbers.

import { t } from "../texts/text.js";
import { fillFacts } from "../util/dom.js";
import { fixed, seconds } from "../util/format.js";
import { figure, prefixed } from "../util/scale.js";

/** @import { Plot } from "../instruments/chart.js" */
/** @import { Diagnostics, Extent } from "../model/messages.js" */

const SPAN = 30; // s on the plot

/** @typedef {Record<"t" | "kinetic" | "rotational" | "potential" | "total", number>} Energies s and J */

/**
 * Computes the energies, with potential energy 0 where gravity leads to: the floor, or a corner. Pure.
 * @param {Pick<Diagnostics, "time" | "kinetic" | "potential" | "rotational">} diagnostics
 * @param {number} mass of all balls, kg
 * @param {{gravity: number, gravity_x: number}} settings
 * @param {Extent} extent of the box
 * @returns {Energies}
 */
export function energies({ time, kinetic, potential, rotational }, mass, settings, extent) {
  const { gravity: down, gravity_x: across } = settings;
  const deepest = Math.max(down * extent.y_min, down * extent.y_max)
    + Math.max(across * extent.x_min, across * extent.x_max);
  const height = potential + mass * deepest;
  return { t: time, kinetic, rotational, potential: height, total: kinetic + rotational + height };
}

/** @param {Iterable<{radius: number, density: number}>} balls @returns {number} kg */
export function massOf(balls) {
  let mass = 0;
  for (const { radius, density } of balls) mass += Math.PI * radius * radius * density;
  return mass;
}

/** The energies of the last SPAN seconds. */
export class EnergyHistory {
  /** @type {Energies[]} */
  rows = [];

  /** @param {Energies} row */
  add(row) {
    const last = this.rows.at(-1);
    if (last && row.t < last.t) this.rows = [];
    if (last && row.t === last.t) this.rows.pop();
    this.rows.push(row);
    while (this.rows.length > 2 && this.rows[1].t < row.t - SPAN) this.rows.shift();
  }

  /** @returns {Plot} */
  plot() {
    const last = this.rows.at(-1)?.t ?? 0;
    const from = Math.max(0, last - SPAN);
    const shown = this.rows.filter((row) => row.t >= from);
    const most = Math.max(1e-9, ...shown.map((row) => Math.max(row.total, row.kinetic)));
    const { unit, per } = prefixed(most, "J");
    /** @param {keyof Energies} name */
    const line = (name) => shown.map((row) => ({ x: row.t, y: per * row[name] }));
    return {
      x: { from, to: Math.max(from + SPAN / 3, last), unit: "s" },
      y: { from: 0, to: 1.08 * per * most, unit },
      series: [
        { points: line("potential"), colour: "other", width: 2, alpha: 0.55 },
        { points: line("rotational"), colour: "ball", width: 2 },
        { points: line("kinetic"), colour: "trayBar", width: 2 },
        { points: line("total"), colour: "trayMark", width: 2.5 },
      ],
    };
  }
}

/** @param {HTMLElement} list @param {Diagnostics} event @param {Energies} row */
export function showFacts(list, event, row) {
  /** @param {number} value */
  const joule = (value) => {
    const { unit, per } = prefixed(Math.max(Math.abs(value), 1e-3), "J");
    return `${steady(per * value)} ${unit}`;
  };
  const momentum = Math.hypot(event.px, event.py);
  fillFacts(list, [
    ["fact.total-energy", joule(row.total)],
    ["fact.kinetic", joule(row.kinetic)],
    ["fact.potential", joule(row.potential)],
    ["fact.rotational", joule(row.rotational)],
    ["fact.momentum", `${steady(momentum)} kg m/s`],
    ["fact.momentum-xy", `${steady(event.px)}, ${steady(event.py)}`],
    ["fact.angular", `${steady(event.angular)} kg m²/s`],
    ["fact.contacts", String(event.contacts)],
    ["fact.deepest-overlap", `${figure(Number((1000 * event.penetration).toPrecision(3)))} mm`],
    ["fact.cell", `${figure(Number((1000 * event.cell).toPrecision(3)))} mm`],
    ["fact.asleep", t("fact.asleep-of", { n: event.asleep, all: event.count })],
    ["fact.time", seconds(event.time)],
  ]);
}

/** @param {number} value */
function steady(value) {
  const size = Math.abs(value);
  if (size >= 1e5) return figure(value);
  const text = fixed(size, size >= 100 ? 0 : size >= 10 ? 1 : 2);
  return value < 0 && /[1-9]/.test(text) ? `−${text}` : text;
}
