// The fields of a board's JSON form, in the order of its digest, with ranges and defaults.
// `make readme` writes this file from engine/board/form.py.

/**
 * @typedef {{name: string, low?: number, high?: number, most?: number, otherwise?: number}} Field
 *   most: items of a list; otherwise: the default
 */

/** @satisfies {Record<string, Field[]>} */
export const FORM = {
  board: [
    { name: "name", most: 100 },
    { name: "width", low: 1e-06, high: 2000000, otherwise: 8 },
    { name: "height", low: 1e-06, high: 2000000, otherwise: 6 },
    { name: "gravity", low: 1e-06, high: 10000, otherwise: 9.81 },
    { name: "drag", low: 0, high: 1000, otherwise: 0 },
    { name: "ball" },
    { name: "pegs", most: 20000 },
    { name: "peg_material" },
    { name: "walls", most: 2000 },
    { name: "wall_material" },
    { name: "bins" },
    { name: "drop" },
  ],
  ball: [
    { name: "radius", low: 1e-06, high: 10000, otherwise: 0.08 },
    { name: "density", low: 1e-09, high: 1000000000, otherwise: 1 },
    { name: "restitution", low: 0, high: 1, otherwise: 0.6 },
    { name: "friction", low: 0, high: 10, otherwise: 0 },
  ],
  peg: [
    { name: "x", low: -1000000, high: 1000000 },
    { name: "y", low: -1000000, high: 1000000 },
    { name: "radius", low: 1e-06, high: 10000 },
  ],
  wall: [
    { name: "x1", low: -1000000, high: 1000000 },
    { name: "y1", low: -1000000, high: 1000000 },
    { name: "x2", low: -1000000, high: 1000000 },
    { name: "y2", low: -1000000, high: 1000000 },
  ],
  material: [
    { name: "restitution", low: 0, high: 1, otherwise: 0.6 },
    { name: "friction", low: 0, high: 10, otherwise: 0 },
  ],
  bins: [
    { name: "y", low: -1000000, high: 1000000 },
    { name: "edges", low: -1000000, high: 1000000, most: 1001 },
    { name: "multipliers", low: 0, high: 1000000000, most: 1000 },
    { name: "labels", most: 1000 },
  ],
  label: [
    { name: "text", most: 40 },
    { name: "colour" },
  ],
  drop: [
    { name: "x", low: -1000000, high: 1000000, otherwise: 0 },
    { name: "y", low: -1000000, high: 1000000, otherwise: 0 },
    { name: "jitter", low: 0, high: 1000000, otherwise: 0 },
    { name: "slots", low: -1000000, high: 1000000, most: 1000 },
    { name: "reach", low: 0, high: 1000000, otherwise: 0 },
    { name: "aim", low: 0, high: 1000000, otherwise: 0 },
  ],
};
