// Normal, impulse and lost energy of an impact, from the states right before and right after it. Pure.
//
// Impulse: J = m (v_after - v_before), m = rho pi R^2. Its part along the normal is the bounce. Its
// part along the tangent is friction, which also spins the ball: I (omega_after - omega_before) = -R J_t.
// The normal points from the peg's centre, or from the wall's nearest point, to the ball's centre.

import { t } from "../texts/text.js";
import { CONTACT_BEGIN, CONTACT_CHANGE, CONTACT_END, LANDING, PEG, WALL } from "./motion/kinds.js";
import { describe } from "./motion/event-names.js";
import { normalAt } from "./normal.js";

/** @import { Board } from "./board.js" */
/** @import { DropEvent } from "./motion/drop.js" */
/** @import { State } from "./motion/flight.js" */

/**
 * @typedef {object} Impact
 * @property {number} t seconds
 * @property {string} what "peg 12", "wall 0", "lands in bin 3" …: English, for files
 * @property {string} told the same in the page's language
 * @property {{x: number, y: number} | null} normal unit, towards the ball; null for a landing
 * @property {{x: number, y: number}} point where the ball touches, metres
 * @property {{x: number, y: number}} impulse N s
 * @property {number} along the impulse along the normal, N s
 * @property {number} across the impulse along the tangent (-n_y, n_x), N s
 * @property {number} approach speed along the normal before, m/s
 * @property {number} lost energy that the impact dissipated, J
 * @property {number} share of the ball's kinetic energy that was lost, 0 … 1
 */

/** @param {Pick<Board, "ball">} board @returns {number} mass of the ball, kg */
function massOf({ ball }) {
  return ball.density * Math.PI * ball.radius * ball.radius;
}

/**
 * @param {Board} board
 * @param {Pick<State, "y" | "vx" | "vy" | "omega">} state
 * @returns {{moving: number, turning: number, height: number, total: number}} joules; height is the
 *   potential energy, zero at the y of the bins
 */
export function energyOf(board, { y, vx, vy, omega }) {
  const mass = massOf(board);
  const { radius } = board.ball;
  const moving = 0.5 * mass * (vx * vx + vy * vy);
  const turning = 0.25 * mass * radius * radius * omega * omega;
  const height = mass * board.gravity * (board.bins.y - y);
  return { moving, turning, height, total: moving + turning + height };
}

/** @param {Board} board @param {DropEvent} event @returns {Impact} */
export function impactOf(board, event) {
  const { kind, index, before, after, t } = event;
  const mass = massOf(board);
  const normal = kind === LANDING ? null : normalAt(board, kind, index, after);
  const impulse = { x: mass * (after.vx - before.vx), y: mass * (after.vy - before.vy) };
  const kinetic = kineticOf(board, before);
  const lost = kind === LANDING ? 0 : kinetic - kineticOf(board, after);
  const n = normal ?? { x: 0, y: 0 };
  return {
    t,
    what: describe(kind, index),
    told: eventText(kind, index),
    normal,
    point: {
      x: after.x - board.ball.radius * n.x,
      y: after.y - board.ball.radius * n.y,
    },
    impulse,
    along: impulse.x * n.x + impulse.y * n.y,
    across: impulse.y * n.x - impulse.x * n.y,
    approach: -(before.vx * n.x + before.vy * n.y),
    lost,
    share: kinetic > 0 ? lost / kinetic : 0,
  };
}

/** @param {Board} board @param {State} state */
function kineticOf(board, state) {
  const { moving, turning } = energyOf(board, state);
  return moving + turning;
}

/** @param {number} kind @param {number} index @returns {string} */
function eventText(kind, index) {
  const surface = index >= 0 ? t("event.peg", { n: index }) : t("event.wall", { n: -1 - index });
  switch (kind) {
    case PEG: return t("event.peg", { n: index });
    case WALL: return t("event.wall", { n: index });
    case CONTACT_BEGIN: return t("event.rides", { surface });
    case CONTACT_CHANGE: return t("event.changes", { surface });
    case CONTACT_END: return t("event.leaves", { surface });
    default: return t("event.lands", { n: index });
  }
}
