// Exact falls with which tests compare drawn ones: keyframes, and free fall with or without drag.

export const G = 9.81; // m/s^2
export const TICK = 1 / 60; // s

/** A keyframe with velocities on both sides, unless `more` changes that. */
export function keyframe(t, x, y, vx, vy, more = {}) {
  return { t, x, y, vx, vy, angle: 0, vIn: true, vOut: true, bounced: false, ...more };
}

/** Place and velocity of a ball that flies from a keyframe. */
export function fall(from, t, drag = 0) {
  const dt = t - from.t;
  const { x, y, vx, vy } = from;
  if (drag === 0) return { x: x + dt * vx, y: y + dt * (vy + 0.5 * G * dt), vx, vy: vy + G * dt };
  const decay = Math.exp(-drag * dt);
  const end = G / drag;
  return {
    x: x + (vx * (1 - decay)) / drag,
    y: y + end * dt + ((vy - end) * (1 - decay)) / drag,
    vx: vx * decay,
    vy: end + (vy - end) * decay,
  };
}
