// Free flight under gravity and linear drag, in closed form. Pure.
//
// The ball follows dv/dt = g - k v. With a0 = g - k v0 and s the time since the start,
//   v(s) = v0 + a0 phi(s),  r(s) = r0 + v0 s + a0 psi(s),
//   phi(s) = (1 - exp(-k s)) / k,  psi(s) = (s - phi(s)) / k.
// Only + - * / are used, in the engine's order, so that the results equal the engine's to the last bit.

// psi(s) = s^2 phi2(k s), phi2(z) = sum of (-z)^n / (n + 2)!. Up to z = 1/4 eleven terms suffice for
// double precision. A longer time is halved until z fits; then formulas for the doubled time lead back.
const SERIES_LIMIT = 0.25;
const EVEN = [1 / 2, 1 / 24, 1 / 720, 1 / 40320, 1 / 3628800, 1 / 479001600];
const ODD = [1 / 6, 1 / 120, 1 / 5040, 1 / 362880, 1 / 39916800];

/**
 * A ball's state: t in s, x and y in m, theta in radians, vx and vy in m/s, omega in rad/s.
 * @typedef {{t: number, x: number, y: number, theta: number, vx: number, vy: number, omega: number}} State
 */

/** @param {number} z from 0 to 1/4 @returns {number} (z - 1 + exp(-z)) / z^2 */
function phi2(z) {
  const w = z * z;
  return horner(EVEN, w) - z * horner(ODD, w);
}

/** @param {number[]} terms @param {number} w */
function horner(terms, w) {
  let total = terms[terms.length - 1];
  for (let i = terms.length - 2; i >= 0; i -= 1) total = terms[i] + w * total;
  return total;
}

/** @param {number} k drag, 1/s @param {number} s seconds @returns {{phi: number, psi: number}} */
export function basis(k, s) {
  if (k === 0) return { phi: s, psi: 0.5 * s * s };
  let z = k * s;
  let h = s;
  let doublings = 0;
  while (z > SERIES_LIMIT) {
    z *= 0.5;
    h *= 0.5;
    doublings += 1;
  }
  let psi = h * h * phi2(z);
  let phi = h - k * psi;
  let decay = 1 - k * phi;
  for (; doublings > 0; doublings -= 1) {
    psi = psi + phi * h + decay * psi;
    phi += decay * phi;
    decay *= decay;
    h += h;
  }
  return { phi, psi };
}

/**
 * The state of a flying ball at a later time.
 * @param {State} from
 * @param {number} t seconds, not before from.t
 * @param {{gravity: number, drag: number}} law m/s^2 and 1/s
 * @returns {State}
 */
export function flown(from, t, { gravity, drag }) {
  const s = t - from.t;
  const { phi, psi } = basis(drag, s);
  const ax = -drag * from.vx;
  const ay = gravity - drag * from.vy;
  return {
    t,
    x: from.x + from.vx * s + ax * psi,
    y: from.y + from.vy * s + ay * psi,
    theta: from.theta + from.omega * s,
    vx: from.vx + ax * phi,
    vy: from.vy + ay * phi,
    omega: from.omega,
  };
}
