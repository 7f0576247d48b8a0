// The plot of the ball's energy over time, and its alternative text. Pure.

import { energyAreas } from "../instruments/energy-areas.js";
import { energyOf } from "../model/impact.js";
import { t } from "../texts/text.js";
import { fixed } from "../util/format.js";
import { figure, prefixed } from "../util/scale.js";

/** @import { Plot } from "../instruments/chart.js" */
/** @import { Motion } from "../model/motion/drop.js" */
/** @import { State } from "../model/motion/flight.js" */

const POINTS = 400;

/**
 * @param {Motion} motion
 * @param {boolean} withHeight whether to include the potential energy
 * @returns {Plot}
 */
export function energyPlot(motion, withHeight) {
  const rows = samples(motion).map((row) => (withHeight ? row : { ...row, height: 0 }));
  return {
    x: { from: 0, to: motion.duration, unit: "s" },
    ...energyAreas(rows),
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
