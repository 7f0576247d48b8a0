// Defaults and ranges of scenes and balls: the same as in app/rooms/touching/values.py and scene.py.

import { ParameterError } from "../errors.js";
import { seedOf } from "../seed.js";

/** @import { Scene } from "./scenes.js" */

/** Lowest and highest allowed value, SI. @type {Record<string, [number, number]>} */
export const RANGES = {
  radius: [0.01, 0.5], density: [0.01, 100_000], restitution: [0, 1], friction: [0, 10],
  gravity: [-100, 100], gravity_x: [-100, 100], drag: [0, 100], damping: [0.9, 1], rolling: [0, 1],
  max_speed: [0, 1000], correction: [0.4, 0.8], projection: [0, 1], dt: [0.001, 0.1], substeps: [1, 32],
  cell: [0, 10], width: [0.5, 20], height: [0.5, 20], speed: [0, 50],
};

/**
 * Defaults of settings that earlier releases did not have. A scene has those that differ from the default.
 */
export const SINCE_2 = { gravity_x: 0, rolling: 0.001, max_speed: 0, projection: 1, cell: 0 };

/** Default settings of the solver. */
export const SOLVER = { damping: 1, correction: 0.6, dt: 1 / 60, substeps: 4, ...SINCE_2 };

/** Default parameters of each scene. @type {Record<"sandbox" | "galton", Scene>} */
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
export const MOST_OVERLAPS = 32; // balls that a new ball may overlap

const MOST_WORK = 16_000; // balls times substeps in a tick

/** @param {number} balls @param {number} dt s @param {number} substeps @param {number} rate ticks a second */
export function isTooMuch(balls, dt, substeps, rate) {
  return (balls * substeps) / (dt * rate) > MOST_WORK;
}

/** @param {string} name @param {number} value @returns {boolean} */
export function isWithin(name, value) {
  const [low, high] = RANGES[name];
  return value >= low && value <= high;
}

/**
 * Checks the parameters of a scene and fills in the defaults.
 * @param {object} form
 * @returns {Scene} throws a ParameterError that names an invalid value
 */
export function sceneOf(form) {
  const { scene } = /** @type {Partial<Scene>} */ (form);
  const found = { ...SCENES[scene === "galton" ? "galton" : "sandbox"], ...form };
  const { balls, seed, dt, substeps, radii = [] } = found;
  for (const [name, value] of Object.entries(found)) {
    if (name in RANGES) check(name, name, /** @type {number} */ (value));
  }
  for (const radius of radii) check("radii", "radius", radius);
  if (radii[0] > radii[1]) throw new ParameterError(`radii ${radii.join(", ")} are not in order: give the smaller one first`, "radii");
  if (!(Number.isInteger(balls) && balls >= 0 && balls <= MOST_BALLS)) {
    throw new ParameterError(`balls ${balls} is not a whole number from 0 to ${MOST_BALLS}`, "balls");
  }
  if (isTooMuch(balls, dt, substeps, 60)) {
    throw new ParameterError(
      `${balls} balls in ${substeps} substeps of ${dt} s take too much work: take fewer balls, fewer `
      + "substeps or a longer dt", "dt",
    );
  }
  for (const name of /** @type {(keyof typeof SINCE_2)[]} */ (Object.keys(SINCE_2))) {
    if (found[name] === SINCE_2[name]) delete found[name];
  }
  return { ...found, seed: String(seedOf(seed)) };
}

/** @param {string} field @param {string} name @param {number} value */
function check(field, name, value) {
  if (isWithin(name, value)) return;
  const [low, high] = RANGES[name];
  throw new ParameterError(`${field} ${value} is not from ${low} to ${high}`, field);
}
