// Where a ball is between two known moments, never cutting through a bounce. Pure.

const KICK = 0.25; // m/s that flight cannot explain: a bounce nobody flagged (a lost snapshot)
const TURN = 2 * Math.PI;

// Filled anew by each call: thousands of calls a picture would leave as many objects behind.
const forth = { x: 0, y: 0, angle: 0 };
const back = { x: 0, y: 0, angle: 0 };
const end = { x: 0, y: 0, angle: 0 };
const corner = { t: 0, x: 0, y: 0 };

/**
 * A known moment of a ball's path.
 * @typedef {object} Keyframe
 * @property {number} t seconds
 * @property {number} x metres
 * @property {number} y metres, down
 * @property {number} angle radians
 * @property {number} vx m/s; read only when vIn or vOut says that it holds
 * @property {number} vy m/s
 * @property {boolean} vIn the velocity holds just before this moment
 * @property {boolean} vOut the velocity holds just after it
 * @property {boolean} bounced something was hit between the keyframe before and this one
 * @property {boolean} [smooth] nothing was, though the ball may have lain on something: both
 *   velocities hold, and no guess is made
 */

/** @typedef {{gravity: number, drag: number}} Law m/s^2 and 1/s: how a ball falls in between */
/** @typedef {{x: number, y: number, angle: number}} Pose */

/**
 * The pose at a time between two keyframes.
 *
 * - No bounce between them: the cubic through both positions and velocities, which is exact for
 *   a parabola.
 * - A bounce: flight forwards from a until it meets the flight backwards from b. The rounding of
 *   the wire leaves a small gap there; it is spread over both arcs, so that the path passes
 *   through both keyframes and is continuous.
 * - A keyframe without velocity on this side (a contact's place): flight from the other keyframe, bent
 *   to end there.
 *
 * @param {Keyframe} a
 * @param {Keyframe} b b.t >= a.t
 * @param {number} t a.t <= t <= b.t
 * @param {Law} law
 * @param {Pose} [out] filled and returned
 * @returns {Pose}
 */
export function poseBetween(a, b, t, law, out = { x: 0, y: 0, angle: 0 }) {
  const span = b.t - a.t;
  if (span <= 0) {
    out.x = b.x;
    out.y = b.y;
    out.angle = b.angle;
    return out;
  }
  const s = (t - a.t) / span;
  out.angle = a.angle + s * shortestTurn(a.angle, b.angle);
  if (a.vOut && b.vIn) {
    if (b.bounced || (!b.smooth && kicked(a, b, law))) return bouncePose(a, b, t, law, out);
    return hermitePose(a, b, s, out);
  }
  if (a.vOut) return bentFlight(a, b, t, law, out);
  if (b.vIn) return bentFlight(b, a, t, law, out);
  out.x = a.x + s * (b.x - a.x);
  out.y = a.y + s * (b.y - a.y);
  return out;
}

/**
 * Free flight from (or, for earlier t, to) a keyframe. Second order: over the few hundredths of a
 * second between keyframes the next term of the drag is below a tenth of a pixel.
 * @param {Keyframe} from
 * @param {number} t
 * @param {Law} law
 * @param {Pose} [out]
 */
export function flightPose(from, t, { gravity, drag }, out = { x: 0, y: 0, angle: 0 }) {
  const dt = t - from.t;
  out.x = from.x + dt * (from.vx - 0.5 * dt * drag * from.vx);
  out.y = from.y + dt * (from.vy + 0.5 * dt * (gravity - drag * from.vy));
  return out;
}

/**
 * When the flight forwards from a and the flight backwards from b are nearest.
 *
 * Both fall with the same g, so the gap between them is linear in time: two values give it all.
 * @param {Keyframe} a
 * @param {Keyframe} b
 * @param {Law} law
 * @returns {number} seconds, within [a.t, b.t]
 */
function meetingTime(a, b, law) {
  const backAtA = flightPose(b, a.t, law, back);
  const forthAtB = flightPose(a, b.t, law, forth);
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
function kicked(a, b, { gravity, drag }) {
  const dt = b.t - a.t;
  const dx = b.vx - a.vx + dt * drag * a.vx;
  const dy = b.vy - a.vy - dt * (gravity - drag * a.vy);
  return dx * dx + dy * dy > KICK * KICK;
}

/** @param {Keyframe} a @param {Keyframe} b @param {number} s @param {Pose} out */
function hermitePose(a, b, s, out) {
  const span = b.t - a.t;
  const s2 = s * s;
  const s3 = s2 * s;
  const h01 = 3 * s2 - 2 * s3;
  const h10 = (s3 - 2 * s2 + s) * span;
  const h11 = (s3 - s2) * span;
  out.x = a.x + h01 * (b.x - a.x) + h10 * a.vx + h11 * b.vx;
  out.y = a.y + h01 * (b.y - a.y) + h10 * a.vy + h11 * b.vy;
  return out;
}

/** @param {Keyframe} a @param {Keyframe} b @param {number} t @param {Law} law @param {Pose} out */
function bouncePose(a, b, t, law, out) {
  const meet = meetingTime(a, b, law);
  flightPose(a, meet, law, forth);
  flightPose(b, meet, law, back);
  corner.t = meet;
  corner.x = (forth.x + back.x) / 2;
  corner.y = (forth.y + back.y) / 2;
  return t <= meet ? bentFlight(a, corner, t, law, out) : bentFlight(b, corner, t, law, out);
}

/**
 * Flight from a keyframe, bent linearly in time so that it ends at `to` (before or after it).
 * @param {Keyframe} from
 * @param {Pick<Keyframe, "t" | "x" | "y">} to
 * @param {number} t
 * @param {Law} law
 * @param {Pose} out
 */
function bentFlight(from, to, t, law, out) {
  const span = to.t - from.t;
  const miss = flightPose(from, to.t, law, end);
  const missX = to.x - miss.x;
  const missY = to.y - miss.y;
  const s = span === 0 ? 0 : (t - from.t) / span;
  flightPose(from, t, law, out);
  out.x += s * missX;
  out.y += s * missY;
  return out;
}
