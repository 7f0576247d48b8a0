// The sandbox's columns of sliders: what each sets, in which unit, and how far it goes. Pure.

/** @import { Dial } from "./dials.js" */

/** @type {Dial[]} */
export const WORLD = [
  { name: "gravity", label: "Gravity", low: 0, high: 30, step: 0.01, unit: "m/s²" },
  { name: "restitution", label: "Bounce", low: 0, high: 1, step: 0.005, unit: "" },
  { name: "friction", label: "Friction", low: 0, high: 1, step: 0.01, unit: "" },
  { name: "density", label: "Density", low: 1, high: 10000, log: true, unit: "kg/m²" },
  { name: "drag", label: "Air drag", low: 0, high: 3, step: 0.01, unit: "1/s" },
  { name: "damping", label: "Damping", low: 0.9, high: 1, step: 0.001, unit: "a step" },
];

/** @type {Dial[]} */
export const SOLVER = [
  { name: "dt", label: "Time step", low: 0.001, high: 0.1, log: true, unit: "s",
    show: (value) => `${(1000 * value).toPrecision(3)} ms` },
  { name: "substeps", label: "Substeps", low: 1, high: 32, step: 1, unit: "a step" },
  { name: "correction", label: "Correction", low: 0.4, high: 0.8, step: 0.01, unit: "" },
];

/** @type {Dial[]} */
export const THROW = [
  { name: "radius", label: "Radius", low: 0.02, high: 0.5, log: true, unit: "m" },
  { name: "speed", label: "Speed", low: 0, high: 30, step: 0.5, unit: "m/s" },
  { name: "angle", label: "Direction", low: -180, high: 180, step: 5, unit: "°",
    show: (value) => `${value}° ${directionOf(value)}` },
];

/** @type {Dial[]} */
export const BALL = [
  { name: "radius", label: "Radius", low: 0.02, high: 0.5, log: true, unit: "m" },
  { name: "density", label: "Density", low: 1, high: 10000, log: true, unit: "kg/m²" },
  { name: "restitution", label: "Bounce", low: 0, high: 1, step: 0.005, unit: "" },
  { name: "friction", label: "Friction", low: 0, high: 1, step: 0.01, unit: "" },
];

/** @param {number} angle degrees, anticlockwise from the right @returns {string} */
function directionOf(angle) {
  const names = ["right", "up right", "up", "up left", "left", "down left", "down", "down right"];
  return names[((Math.round(angle / 45) % 8) + 8) % 8];
}
