// A ball's pose between two keyframes, with a corner where it bounced in between. Pure.

// m/s: if the velocity changed by this much more than flight explains, the ball bounced, although no
// snapshot says so (the one that did was lost).
const KICK = 0.25;
const TURN = 2 * Math.PI;

/**
 * @typedef {object} Keyframe
 * @property {number} t seconds
 * @property {number} x metres
 * @property {number} y metres, down
 * @property {number} angle radians
 * @property {number} vx m/s; read only if vIn or vOut is set
 * @property {number} vy m/s
 * @property {boolean} vIn whether the velocity is the ball's just before this moment
 * @property {boolean} vOut whether it is the ball's just after this moment
 * @property {boolean} bounced whether the ball hit something since the previous keyframe
 * @property {boolean} [smooth] whether it certainly hit nothing since the previous keyframe, though it may
 *   have rolled on a surface: an unexpected change of velocity is then no bounce
 */

/** @import { Point } from "../board.js" */

/** @typedef {{gravity: number, across?: number, drag: number}} Law gravity down and to the right, m/s^2; 1/s */
/** @typedef {{x: number, y: number, angle: number}} Pose */

/**
 * The pose at time t between two keyframes.
 *
 * - Without a bounce: the cubic through both positions and velocities, which is exact for a parabola.
 * - With a bounce: flight forwards from a until it meets the flight backwards from b. Because
 *   snapshots are rounded, the two miss each other slightly. The gap is spread over both arcs, so that
 *   the path is continuous and passes through both keyframes.
 * - One keyframe without a velocity on this side (it is the place of a contact): flight from the other
 *   keyframe, bent so that it ends there.
 *
 * @param {Keyframe} a
 * @param {Keyframe} b b.t >= a.t
 * @param {number} t a.t <= t <= b.t
 * @param {Law} law
 * @returns {Pose}
 */
export function poseBetween(a, b, t, law) {
  const span = b.t - a.t;
  if (span <= 0) return { x: b.x, y: b.y, angle: b.angle };
  const s = (t - a.t) / span;
  const angle = a.angle + s * shortestTurn(a.angle, b.angle);
  const { x, y } = placeBetween(a, b, t, s, law);
  return { x, y, angle };
}

/** @param {Keyframe} a @param {Keyframe} b @param {number} t @param {number} s @param {Law} law @returns {Point} */
function placeBetween(a, b, t, s, law) {
  if (!a.vOut && !b.vIn) return { x: a.x + s * (b.x - a.x), y: a.y + s * (b.y - a.y) };
  if (!b.vIn) return bentFlight(a, b, t, law);
  if (!a.vOut) return bentFlight(b, a, t, law);
  const bounces = b.bounced || (!b.smooth && kicked(a, b, law));
  return bounces ? bouncePlace(a, b, t, law) : hermitePlace(a, b, s);
}

/**
 * Free flight from a keyframe, or to it if t is earlier. To second order in time: over the few hundredths
 * of a second between keyframes, the third term is below a tenth of a pixel.
 * @param {Keyframe} from
 * @param {number} t
 * @param {Law} law
 * @returns {Point}
 */
export function flightPlace(from, t, { gravity, across = 0, drag }) {
  const dt = t - from.t;
  return {
    x: from.x + dt * (from.vx + 0.5 * dt * (across - drag * from.vx)),
    y: from.y + dt * (from.vy + 0.5 * dt * (gravity - drag * from.vy)),
  };
}

/**
 * When the flight forwards from a and the flight backwards from b are nearest to each other.
 *
 * Both have the same acceleration, so the gap between them is linear in time, and the gaps at a and at b
 * determine it.
 * @param {Keyframe} a
 * @param {Keyframe} b
 * @param {Law} law
 * @returns {number} seconds, within [a.t, b.t]
 */
function meetingTime(a, b, law) {
  const backAtA = flightPlace(b, a.t, law);
  const forthAtB = flightPlace(a, b.t, law);
  const gap0x = a.x - backAtA.x;
  const gap0y = a.y - backAtA.y;
  const changeX = forthAtB.x - b.x - gap0x;
  const changeY = forthAtB.y - b.y - gap0y;
  const square = changeX * changeX + changeY * changeY;
  const s = square > 0 ? -(gap0x * changeX + gap0y * changeY) / square : 0.5;
  return a.t + Math.max(0, Math.min(1, s)) * (b.t - a.t);
}

/** @param {number} from @param {number} to @returns {number} the turn in (-pi, pi] */
export function shortestTurn(from, to) {
  const turn = (((to - from) % TURN) + TURN) % TURN;
  return turn > Math.PI ? turn - TURN : turn;
}

/** @param {Keyframe} a @param {Keyframe} b @param {Law} law */
function kicked(a, b, { gravity, across = 0, drag }) {
  const dt = b.t - a.t;
  const dx = b.vx - a.vx - dt * (across - drag * a.vx);
  const dy = b.vy - a.vy - dt * (gravity - drag * a.vy);
  return dx * dx + dy * dy > KICK * KICK;
}

/** @param {Keyframe} a @param {Keyframe} b @param {number} s @returns {Point} */
function hermitePlace(a, b, s) {
  const span = b.t - a.t;
  const s2 = s * s;
  const s3 = s2 * s;
  const h01 = 3 * s2 - 2 * s3;
  const h10 = (s3 - 2 * s2 + s) * span;
  const h11 = (s3 - s2) * span;
  return {
    x: a.x + h01 * (b.x - a.x) + h10 * a.vx + h11 * b.vx,
    y: a.y + h01 * (b.y - a.y) + h10 * a.vy + h11 * b.vy,
  };
}

/** @param {Keyframe} a @param {Keyframe} b @param {number} t @param {Law} law @returns {Point} */
function bouncePlace(a, b, t, law) {
  const meet = meetingTime(a, b, law);
  const [forth, back] = [flightPlace(a, meet, law), flightPlace(b, meet, law)];
  const corner = { t: meet, x: (forth.x + back.x) / 2, y: (forth.y + back.y) / 2 };
  return bentFlight(t <= meet ? a : b, corner, t, law);
}

/**
 * Flight from a keyframe, plus a shift that grows linearly in time, so that it ends at `to` (before or
 * after the keyframe).
 * @param {Keyframe} from
 * @param {Pick<Keyframe, "t" | "x" | "y">} to
 * @param {number} t
 * @param {Law} law
 * @returns {Point}
 */
function bentFlight(from, to, t, law) {
  const span = to.t - from.t;
  const end = flightPlace(from, to.t, law);
  const s = span === 0 ? 0 : (t - from.t) / span;
  const { x, y } = flightPlace(from, t, law);
  return { x: x + s * (to.x - end.x), y: y + s * (to.y - end.y) };
}
