// A segment of a ball's path (free flight, or a curve along a surface), and the ball's pose on it. Pure.

import { basis } from "./flight.js";

/** @import { Law, Pose } from "./interpolate.js" */

/** How a flight begins, or what a curve runs along. */
export const KIND = { offPeg: 0, offWall: 1, leftPeg: 2, leftWall: 3, dropped: 4, underWay: 5 };

/**
 * Free flight, or with a bend a parabola along a surface.
 * @typedef {object} Segment
 * @property {number} id ball number mod 65536
 * @property {number} kind one of KIND
 * @property {number} index of the peg or wall
 * @property {number} t its start in table time: seconds since the room's tick 0
 * @property {number} x metres
 * @property {number} y metres, down
 * @property {number} vx m/s
 * @property {number} vy m/s
 * @property {number} angle radians, clockwise
 * @property {number} spin rad/s
 * @property {{ax: number, ay: number}} [bend] a curve's acceleration, m/s^2
 */

/**
 * The ball's pose on a segment. A flight is r + v s + a psi(s), where a = g - k v is the acceleration at
 * its start. A curve has a constant acceleration.
 * @param {Segment} segment
 * @param {number} t table time, s
 * @param {Law} law
 * @param {Pose} [out] filled and returned
 * @returns {Pose}
 */
export function segmentPose(segment, t, { gravity, drag }, out = { x: 0, y: 0, angle: 0 }) {
  const s = t - segment.t;
  const { bend } = segment;
  const ax = bend ? bend.ax : -drag * segment.vx;
  const ay = bend ? bend.ay : gravity - drag * segment.vy;
  const { psi } = basis(bend ? 0 : drag, s);
  out.x = segment.x + segment.vx * s + ax * psi;
  out.y = segment.y + segment.vy * s + ay * psi;
  out.angle = segment.angle + segment.spin * s;
  return out;
}

/**
 * @param {Segment} segment
 * @param {number} t table time, s
 * @param {Law} law
 * @returns {{vx: number, vy: number}} m/s; on a curve an approximation
 */
export function segmentVelocity(segment, t, { gravity, drag }) {
  const s = t - segment.t;
  const { bend } = segment;
  if (bend) return { vx: segment.vx + bend.ax * s, vy: segment.vy + bend.ay * s };
  const { phi } = basis(drag, s);
  return {
    vx: segment.vx - drag * segment.vx * phi,
    vy: segment.vy + (gravity - drag * segment.vy) * phi,
  };
}
