// What scenes and balls have unless it is said, and how far each value may go: those of the server,
// app/rooms/touching/values.py and scene.py.

/** @import { Scene } from "./scenes.js" */

/** Least and greatest value, SI. @type {Record<string, [number, number]>} */
export const RANGES = {
  radius: [0.01, 0.5], density: [0.01, 100_000], restitution: [0, 1], friction: [0, 10],
  gravity: [0, 100], drag: [0, 100], damping: [0.9, 1], correction: [0.4, 0.8], dt: [0.001, 0.1],
  substeps: [1, 32],
};

const SOLVER = { damping: 1, correction: 0.6, dt: 1 / 60, substeps: 4 };

/** The scenes as they are unless more is said. @type {Record<"sandbox" | "galton", Scene>} */
export const SCENES = {
  sandbox: {
    scene: "sandbox", balls: 60, seed: "1", width: 6, height: 4, radii: [0.06, 0.16], speed: 0,
    density: 80, restitution: 0.9, friction: 0.2, gravity: 9.81, drag: 0, ...SOLVER,
  },
  galton: {
    scene: "galton", balls: 300, seed: "1", density: 80, restitution: 0.5, friction: 0.1,
    gravity: 9.81, drag: 2.2, ...SOLVER,
  },
};

export const MOST_BALLS = 500;

const MOST_WORK = 16_000; // balls times substeps in a tick

/** @param {number} balls @param {number} dt s @param {number} substeps @param {number} rate ticks a second */
export function isTooMuch(balls, dt, substeps, rate) {
  return (balls * substeps) / (dt * rate) > MOST_WORK;
}

/** @param {string} name @param {number} value @returns {boolean} whether the value may be that */
export function isWithin(name, value) {
  const [low, high] = RANGES[name];
  return value >= low && value <= high;
}
