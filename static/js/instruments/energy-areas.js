// The energies of height, motion and spin as stacked areas of a plot. Pure.

import { prefixed } from "../util/scale.js";

/** @import { Plot } from "./chart.js" */

/** @typedef {Record<"t" | "height" | "moving" | "turning", number>} EnergyRow s and J */

/** @param {EnergyRow[]} rows in time order @returns {Pick<Plot, "y" | "series">} the last series is the total energy */
export function energyAreas(rows) {
  const most = rows.reduce((top, { height, moving, turning }) => Math.max(top, height + moving + turning), 1e-9);
  const { unit, per } = prefixed(most, "J");
  /** @param {(row: EnergyRow) => number} value */
  const level = (value) => rows.map((row) => ({ x: row.t, y: per * value(row) }));
  const ground = level(() => 0);
  const height = level((row) => row.height);
  const moving = level((row) => row.height + row.moving);
  const total = level((row) => row.height + row.moving + row.turning);
  return {
    y: { from: 0, to: per * most, unit },
    series: [
      { points: height, base: ground, colour: "other", alpha: 0.45 },
      { points: moving, base: height, colour: "trayBar", alpha: 0.9 },
      { points: total, base: moving, colour: "ball" },
      { points: total, colour: "trayMark", width: 1.5 },
    ],
  };
}
