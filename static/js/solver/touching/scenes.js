// Lays out the scenes: balls in a box, and a pile-up on a Galton board. The same seed gives the same
// places as in engine/multibody/scenes.py and app/rooms/touching/scene.py.

import { ParameterError } from "../errors.js";
import { splitmix64 } from "../seed.js";

/** @import { Board } from "../../model/board.js" */
/** @import { BallValues } from "./ball-table.js" */
/** @import { SINCE_2 } from "./values.js" */

const CELL = 2.3; // distance between the balls' places, in radii of the largest ball
const MASK = (1n << 64n) - 1n;
const UNIT = 2 ** -53;
const DEPTH = 1.2; // of the Galton board's bins, m

/**
 * Pegs, walls and bins, and their materials; m.
 * @typedef {Pick<Board, "pegs" | "walls" | "peg_material" | "wall_material"> & {bins: Board["bins"] | null}} Place
 */

/**
 * All parameters of a scene, in the server's JSON form.
 * @typedef {{scene: "sandbox" | "galton", balls: number, seed: string, gravity: number, drag: number,
 *   damping: number, correction: number, dt: number, substeps: number, density: number,
 *   restitution: number, friction: number, width?: number, height?: number, radii?: number[],
 *   speed?: number} & Partial<typeof SINCE_2>} Scene
 *
 * @typedef {{place: Place, balls: (Partial<BallValues> & {x: number, y: number})[]}} Opening
 */

/**
 * The fields of a board's JSON that the Galton scene uses.
 * @typedef {{pegs: Place["pegs"], bins: {y: number, edges: number[]}, drop: {y: number},
 *   ball: {radius: number}}} GaltonBoard
 */

/**
 * @param {Scene} scene
 * @param {GaltonBoard | null} board the preset `galton`, for the scene `galton`
 * @returns {Opening}
 */
export function openingOf(scene, board) {
  if (scene.scene === "sandbox") return box(scene);
  if (!board) throw new Error("the scene galton needs a board: give the preset galton's");
  return galton(scene, board);
}

/** @param {Scene} scene @returns {Opening} */
function box({ balls: n, seed, width = 6, height = 4, radii = [0.06, 0.16], speed = 0, ...made }) {
  const half = 0.5 * width;
  const corners = [[-half, 0], [half, 0], [half, height], [-half, height]];
  const walls = corners.map(([x1, y1], i) => {
    const [x2, y2] = corners[(i + 1) % 4];
    return { x1, y1, x2, y2 };
  });
  const place = { pegs: [], walls, ...fixed(made.friction), bins: null };
  const [low, high] = radii;
  const first = BigInt(seed);
  const at = lattice(n, width, height, high, first);
  const vx = uniform(first + 2n, n, -speed, speed);
  const vy = uniform(first + 3n, n, -speed, speed);
  const radius = uniform(first + 4n, n, low, high);
  const { density, restitution, friction } = made;
  const balls = at.map(([x, y], i) => ({
    x, y, vx: vx[i], vy: vy[i], radius: radius[i], density, restitution, friction,
  }));
  return { place, balls };
}

/**
 * The materials of pegs and walls. An impact uses the greater restitution of the two bodies: with 0 here,
 * that of the ball decides.
 * @param {number} friction
 */
function fixed(friction) {
  const material = { restitution: 0, friction };
  return { peg_material: material, wall_material: material };
}

/**
 * Places for n balls of at most `radius` in a box: in rows, each shifted at random, so that no two touch.
 * @param {number} n @param {number} width @param {number} height @param {number} radius
 * @param {bigint} seed
 * @returns {[number, number][]}
 */
function lattice(n, width, height, radius, seed) {
  let cell = CELL * radius;
  if (n * cell * cell < 0.5 * width * height) cell = Math.sqrt((0.5 * width * height) / n);
  const [columns, rows] = [Math.floor(width / cell), Math.floor(height / cell)];
  if (columns * rows < n) throw new ParameterError(`${n} balls do not fit into the box: at most ${columns * rows} do`, "balls");
  const room = 0.5 * cell - radius;
  const dx = uniform(seed, n, -room, room);
  const dy = uniform(seed + 1n, n, -room, room);
  return Array.from({ length: n }, (_, i) => {
    const x = -0.5 * width + ((i % columns) + 0.5) * (width / columns);
    const y = (Math.floor(i / columns) + 0.5) * (height / rows);
    return [x + dx[i], y + dy[i]];
  });
}

/** @param {Scene} scene @param {GaltonBoard} board @returns {Opening} */
function galton({ balls: n, seed, density, restitution, friction }, board) {
  const { bins: { y: top, edges }, ball: { radius } } = board;
  const floor = top + DEPTH;
  const [left, right] = [edges[0], edges[edges.length - 1]];
  const cell = CELL * radius;
  const columns = Math.floor((0.35 * (right - left)) / cell);
  const rise = cell * (Math.floor(n / columns) + 4);
  const upright = (/** @type {number} */ x, /** @type {number} */ y1) => ({ x1: x, y1, x2: x, y2: floor });
  const walls = [
    upright(left, -rise), upright(right, -rise), { x1: left, y1: floor, x2: right, y2: floor },
    ...edges.slice(1, -1).map((x) => upright(x, top)),
  ];
  const room = 0.5 * cell - radius;
  const dx = uniform(BigInt(seed), n, -room, room);
  const dy = uniform(BigInt(seed) + 1n, n, -room, room);
  const balls = Array.from({ length: n }, (_, i) => ({
    x: ((i % columns) - 0.5 * (columns - 1)) * cell + dx[i],
    y: board.drop.y - Math.floor(i / columns) * cell + dy[i],
    radius, density, restitution, friction,
  }));
  return { place: { pegs: board.pegs, walls, ...fixed(friction), bins: null }, balls };
}

/**
 * Random numbers in [low, high), by SplitMix64.
 * @param {bigint} seed @param {number} count @param {number} low @param {number} high
 * @returns {number[]}
 */
function uniform(seed, count, low, high) {
  const first = splitmix64(seed & MASK);
  return Array.from({ length: count }, (_, i) => {
    const draw = splitmix64((first + BigInt(i)) & MASK) >> 11n;
    return low + (high - low) * (Number(draw) * UNIT);
  });
}
