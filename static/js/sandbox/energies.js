// What is measured in the box: the last half minute of energies as a plot, and the rest as numbers.

import { fillFacts } from "../util/dom.js";
import { figure, prefixed } from "../util/scale.js";

/** @import { Plot } from "../instruments/chart.js" */
/** @import { Diagnostics } from "../model/messages.js" */

const SPAN = 30; // s on the plot

/** @typedef {Record<"t" | "kinetic" | "rotational" | "potential" | "total", number>} Energies s and J */

/**
 * Energies with the height counted from the floor. Pure.
 * @param {Pick<Diagnostics, "time" | "kinetic" | "potential" | "rotational">} diagnostics
 * @param {number} weight of all balls, N
 * @param {number} floor y of the floor, m
 * @returns {Energies}
 */
export function energies({ time, kinetic, potential, rotational }, weight, floor) {
  const height = potential + weight * floor;
  return { t: time, kinetic, rotational, potential: height, total: kinetic + rotational + height };
}

/** @param {Iterable<{radius: number, density: number}>} balls @returns {number} kg */
export function massOf(balls) {
  let mass = 0;
  for (const { radius, density } of balls) mass += Math.PI * radius * radius * density;
  return mass;
}

/** The energies of late. */
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

  clear() {
    this.rows = [];
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
    return `${fixed(per * value)} ${unit}`;
  };
  const momentum = Math.hypot(event.px, event.py);
  fillFacts(list, [
    ["Total energy", joule(row.total)],
    ["Kinetic", joule(row.kinetic)],
    ["Potential", joule(row.potential)],
    ["Rotational", joule(row.rotational)],
    ["Momentum", `${fixed(momentum)} kg m/s`],
    ["Momentum x, y", `${fixed(event.px)}, ${fixed(event.py)}`],
    ["Angular", `${fixed(event.angular)} kg m²/s`],
    ["Contacts", String(event.contacts)],
    ["Deepest overlap", `${figure(Number((1000 * event.penetration).toPrecision(3)))} mm`],
    ["Asleep", `${event.asleep} of ${event.count}`],
    ["Time", `${event.time.toFixed(2)} s`],
  ]);
}

/** @param {number} value */
function fixed(value) {
  const size = Math.abs(value);
  const text = size >= 1e5 ? figure(value) : value.toFixed(size >= 100 ? 0 : size >= 10 ? 1 : 2);
  return /^-0(\.0+)?$/.test(text) ? text.slice(1) : text.replace("-", "−");
}
