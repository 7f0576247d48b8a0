// The sandbox's sliders: each one's setting, unit and range. Pure.

import { t } from "../texts/text.js";
import { rounded } from "../util/format.js";

/** @import { Dial } from "./dials.js" */

/** @type {Dial[]} */
export const WORLD = [
  { name: "gravity", label: t("word.gravity"), low: -30, high: 30, step: 0.01, unit: "m/s²" },
  { name: "gravity_x", label: t("box.gravity-x"), low: -30, high: 30, step: 0.01, unit: "m/s²", rare: true },
  { name: "restitution", label: t("box.bounce"), low: 0, high: 1, step: 0.005, unit: "" },
  { name: "friction", label: t("box.friction"), low: 0, high: 1, step: 0.01, unit: "", rare: true },
  { name: "density", label: t("box.density"), low: 1, high: 10000, log: true, unit: "kg/m²", rare: true },
  { name: "drag", label: t("box.drag"), low: 0, high: 3, step: 0.01, unit: "1/s", rare: true },
  { name: "rolling", label: t("box.rolling"), low: 0, high: 0.1, step: 0.001, unit: "", rare: true },
  { name: "max_speed", label: t("box.max-speed"), low: 0, high: 50, step: 0.5, unit: "m/s", rare: true,
    show: (value) => (value ? `${value} m/s` : t("box.no-limit")) },
  { name: "damping", label: t("box.damping"), low: 0.9, high: 1, step: 0.001, unit: t("box.a-step"), rare: true },
];

/** @type {Dial[]} */
export const SOLVER = [
  { name: "dt", label: t("box.time-step"), low: 0.001, high: 0.1, log: true, unit: "s",
    show: (value) => `${rounded(1000 * value, 3)} ms` },
  { name: "substeps", label: t("box.substeps"), low: 1, high: 32, step: 1, unit: t("box.a-step") },
  { name: "correction", label: t("box.correction"), low: 0.4, high: 0.8, step: 0.01, unit: "" },
  { name: "projection", label: t("box.projection"), low: 0, high: 1, step: 1, unit: "",
    show: (value) => (value ? t("box.on") : t("box.off")) },
  { name: "cell", label: t("box.cell"), low: 0, high: 2, step: 0.01, unit: "m",
    show: (value) => (value ? `${rounded(value, 2)} m` : t("box.cell-chosen")) },
];

/** @type {Dial[]} */
export const THROW = [
  { name: "radius", label: t("box.radius"), low: 0.02, high: 0.5, log: true, unit: "m" },
  { name: "speed", label: t("word.speed"), low: 0, high: 30, step: 0.5, unit: "m/s" },
  { name: "angle", label: t("box.direction"), low: -180, high: 180, step: 5, unit: "°", rare: true,
    show: (value) => `${value}° ${directionOf(value)}` },
];

/** @type {Dial[]} */
export const BALL = [
  { name: "radius", label: t("box.radius"), low: 0.02, high: 0.5, log: true, unit: "m" },
  { name: "density", label: t("box.density"), low: 1, high: 10000, log: true, unit: "kg/m²" },
  { name: "restitution", label: t("box.bounce"), low: 0, high: 1, step: 0.005, unit: "" },
  { name: "friction", label: t("box.friction"), low: 0, high: 1, step: 0.01, unit: "" },
];

/** @param {number} angle degrees, anticlockwise from the right @returns {string} */
function directionOf(angle) {
  const names = [t("box.right"), t("box.up-right"), t("box.up"), t("box.up-left"), t("box.left"), t("box.down-left"),
    t("box.down"), t("box.down-right")];
  return names[((Math.round(angle / 45) % 8) + 8) % 8];
}
