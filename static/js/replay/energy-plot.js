// The plot of the ball's energy over time, and its alternative text. Pure.

import { energyOf } from "../model/impact.js";
import { t } from "../texts/text.js";
import { fixed } from "../util/format.js";
import { figure, prefixed } from "../util/scale.js";

/** @import { Plot } from "../instruments/chart.js" */
/** @import { Motion } from "../model/motion/drop.js" */
/** @import { State } from "../model/motion/flight.js" */

const POINTS = 400;

/**
 * The energies of height, motion and spin as stacked areas, and their total.
 * @param {Motion} motion
 * @param {boolean} withHeight whether to include the potential energy
 * @returns {Plot}
 */
export function energyPlot(motion, withHeight) {
  const rows = samples(motion).map((row) => (withHeight ? row : { ...row, height: 0 }));
  const most = rows.reduce((top, { height, moving, turning }) => Math.max(top, height + moving + turning), 1e-9);
  const { unit, per } = prefixed(most, "J");
  /** @param {(row: typeof rows[0]) => number} value */
  const level = (value) => rows.map((row) => ({ x: row.t, y: per * value(row) }));
  const height = level((row) => row.height);
  const moving = level((row) => row.height + row.moving);
  const total = level((row) => row.height + row.moving + row.turning);
  return {
    x: { from: 0, to: motion.duration, unit: "s" },
    y: { from: 0, to: per * most, unit },
    series: [
      { points: height, base: level(() => 0), colour: "other", alpha: 0.45 },
      { points: moving, base: height, colour: "trayBar", alpha: 0.9 },
      { points: total, base: moving, colour: "ball" },
      { points: total, colour: "trayMark", width: 1.5 },
    ],
    events: motion.events.map(({ t }) => t),
  };
}

/**
 * Energies in time order. At each event there is a sample right before and right after it, so that the
 * step is vertical.
 * @param {Motion} motion
 */
function samples(motion) {
  /** @param {State} state */
  const at = (state) => ({ t: state.t, ...energyOf(motion.board, state) });
  const rows = Array.from({ length: POINTS + 1 }, (_, i) =>
    at(motion.stateAt((i / POINTS) * motion.duration)));
  for (const { before, after } of motion.events) rows.push(at(before), at(after));
  // The sort is stable, so `before` stays in front of `after`.
  return rows.sort((a, b) => a.t - b.t);
}

/** @param {Motion} motion @returns {string} the plot's alternative text */
export function describeEnergy(motion) {
  const first = energyOf(motion.board, motion.start).total;
  const last = energyOf(motion.board, motion.end).total;
  const { unit, per } = prefixed(first, "J");
  return t("replay.energy-words", {
    first: figure(per * first), unit, last: figure(per * last),
    share: fixed(100 * (1 - last / first), 0), n: motion.hits.length,
  });
}
