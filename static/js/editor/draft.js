// A board being edited: its elements, and new boards made from it by single changes. Pure.

import * as element from "./element.js";
import * as group from "./group.js";

export { withPeg, withSplit, withWall } from "./element.js";

/** @typedef {import("./element.js").Ref} Ref */

/** What a board has where its JSON leaves it out; the server's own defaults. */
const DEFAULTS = {
  name: "board", width: 8, height: 6, gravity: 9.81, drag: 0,
  ball: { radius: 0.08, density: 1, restitution: 0.6, friction: 0 },
  peg_material: { restitution: 0.6, friction: 0 },
  wall_material: { restitution: 0.6, friction: 0 },
  drop: { x: 0, y: 0, jitter: 0 },
};

/** A board to start from: three pegs over three bins. */
export const EMPTY = {
  name: "my board", width: 4, height: 3, gravity: 9.81, drag: 0.5,
  ball: { radius: 0.08, density: 1, restitution: 0.6, friction: 0.1 },
  pegs: [
    { x: 0, y: 0.8, radius: 0.05 }, { x: -0.5, y: 1.4, radius: 0.05 }, { x: 0.5, y: 1.4, radius: 0.05 },
  ],
  peg_material: { restitution: 0.6, friction: 0.1 },
  walls: [{ x1: -1.5, y1: -0.5, x2: -1.5, y2: 2.4 }, { x1: 1.5, y1: -0.5, x2: 1.5, y2: 2.4 }],
  wall_material: { restitution: 0.6, friction: 0.1 },
  bins: { y: 2.4, edges: [-1.5, -0.5, 0.5, 1.5], multipliers: [2, 0.5, 2] },
  drop: { x: 0, y: 0, jitter: 0.25 },
};

/**
 * A file's or a link's board with all parts that drawing needs.
 * @param {any} form
 * @returns {any} throws a RangeError that says what it lacks
 */
export function complete(form) {
  if (form === null || typeof form !== "object" || Array.isArray(form)) {
    throw new RangeError("A board is a JSON object.");
  }
  const board = { ...DEFAULTS, pegs: [], ...form };
  for (const part of ["ball", "peg_material", "wall_material", "drop"]) {
    board[part] = { ...DEFAULTS[part], ...form[part] };
  }
  board.bins = completeBins(form.bins ?? {}, board);
  board.walls = form.walls ?? sideWalls(board);
  const numbers = [board.gravity, board.ball.radius, board.drop.x, board.drop.y, board.drop.jitter];
  numbers.push(board.drop.reach ?? 0);
  for (const peg of list(board.pegs, "pegs")) numbers.push(peg?.x, peg?.y, peg?.radius);
  for (const wall of list(board.walls, "walls")) numbers.push(wall?.x1, wall?.y1, wall?.x2, wall?.y2);
  numbers.push(board.bins.y, ...board.bins.edges, ...board.bins.multipliers);
  if (!numbers.every(Number.isFinite)) {
    throw new RangeError("Some place or size on the board is not a number, so it cannot be drawn.");
  }
  return board;
}

function completeBins(bins, { width, height }) {
  const edges = bins.edges ?? null;
  const count = edges ? edges.length - 1 : Math.max(1, bins.multipliers?.length ?? 1);
  const made = {
    y: bins.y ?? height,
    edges: edges ?? Array.from({ length: count + 1 }, (_, i) => (width * (2 * i - count)) / (2 * count)),
    multipliers: bins.multipliers ?? Array(count).fill(1),
  };
  const rises = made.edges.every((edge, i) => i === 0 || edge > made.edges[i - 1]);
  if (count < 1 || !rises || made.multipliers.length !== count) {
    throw new RangeError("The bins need edges that rise, and one multiplier between each two.");
  }
  return made;
}

function sideWalls({ drop, ball, bins }) {
  const top = drop.y - 2 * ball.radius;
  return [bins.edges[0], bins.edges[bins.edges.length - 1]].map((x) => ({
    x1: x, y1: top, x2: x, y2: bins.y,
  }));
}

function list(value, name) {
  if (!Array.isArray(value)) throw new RangeError(`The board's ${name} are not a list.`);
  return value;
}

/** @param {any} board @returns {Ref[]} all elements, in the order in which keys go through them */
export function refsOf({ pegs, walls, bins }) {
  const each = (kind, items) => items.map((_, index) => ({ kind, index }));
  return [
    { kind: "drop", index: 0 },
    ...each("peg", pegs),
    ...each("wall", walls),
    ...each("edge", bins.edges),
    ...each("bin", bins.multipliers),
  ];
}

/** @param {Ref | null} one @param {Ref | null} two */
export function sameRef(one, two) {
  if (one?.refs || two?.refs) return group.same(one, two);
  return element.sameElement(one, two);
}

/** @returns {boolean} whether the board has this element */
export function holds(board, { kind, index, refs }) {
  if (refs) return refs.every((ref) => holds(board, ref));
  const { pegs, walls, bins } = board;
  const count = {
    drop: 1, peg: pegs.length, wall: walls.length, edge: bins.edges.length, bin: bins.multipliers.length,
  }[kind];
  return index < count;
}

/** @param {any} board @param {Ref} ref @returns {{x: number, y: number}} metres */
export function placeOf(board, ref) {
  return element.placeOf(board, ref.refs ? ref.refs[0] : ref);
}

/** @returns {any} the board with an element at (x, y), as far as it may go there */
export function moved(board, ref, x, y) {
  return ref.refs ? group.moved(board, ref.refs, x, y) : element.moved(board, ref, x, y);
}

/** @returns {any | null} the board without an element; null where it has to stay */
export function without(board, ref) {
  return ref.refs ? group.without(board, ref.refs) : element.without(board, ref);
}

/** @returns {{board: any, ref: Ref} | null} the board with a copy of pegs and walls beside them */
export function duplicated(board, ref, by) {
  return ref.refs ? group.duplicated(board, ref.refs, by) : element.duplicated(board, ref, by);
}

/**
 * @param {any} board
 * @param {string} path "gravity", "ball.radius", "pegs[3].x", "bins.multipliers[2]"
 * @returns {any} what is there
 */
export function read(board, path) {
  return steps(path).reduce((part, step) => part?.[step], board);
}

/** @returns {any} the board with another value at a path */
export function written(board, path, value) {
  const put = (part, [step, ...rest]) => {
    const next = rest.length ? put(part[step], rest) : value;
    return Array.isArray(part) ? part.with(step, next) : { ...part, [step]: next };
  };
  return put(board, steps(path));
}

function steps(path) {
  return path.split(/[.[\]]+/).filter(Boolean).map((step) => (/^\d+$/.test(step) ? Number(step) : step));
}

/** @returns {number} value at the nearest multiple of a step; a step of 0 leaves it */
export function snap(value, step) {
  if (step === 0) return value;
  // Multiples written in decimal, so that 0.3 is stored as 0.3.
  return Number((Math.round(value / step) * step).toPrecision(12));
}

/**
 * The element at a place, the smallest first.
 * @param {any} board
 * @param {number} x metres
 * @param {number} y metres
 * @param {number} reach metres that a miss may be
 * @returns {Ref | null}
 */
export function hit(board, x, y, reach) {
  const away = (place) => Math.hypot(place.x - x, place.y - y);
  const found = [];
  board.walls.forEach((_, index) => {
    for (const end of [1, 2]) {
      const ref = { kind: "wall", index, end };
      found.push([away(placeOf(board, ref)), ref]);
    }
  });
  board.pegs.forEach((peg, index) => {
    found.push([away(peg) - peg.radius, { kind: "peg", index }]);
  });
  found.push([away(board.drop) - board.ball.radius, { kind: "drop", index: 0 }]);
  // An edge goes on downwards between its bins; at its top a wall may end, which comes first.
  board.bins.edges.forEach((edge, index) => {
    const below = Math.max(y, board.bins.y);
    found.push([away({ x: edge, y: below }), { kind: "edge", index }]);
  });
  const nearest = found.reduce((best, one) => (one[0] < best[0] ? one : best));
  if (nearest[0] <= reach) return nearest[1];
  return wallAt(board, x, y, reach) ?? binAt(board, x, y);
}

function wallAt({ walls }, x, y, reach) {
  const index = walls.findIndex(({ x1, y1, x2, y2 }) => {
    const [dx, dy] = [x2 - x1, y2 - y1];
    const square = dx * dx + dy * dy;
    const s = square ? Math.min(1, Math.max(0, ((x - x1) * dx + (y - y1) * dy) / square)) : 0;
    return Math.hypot(x1 + s * dx - x, y1 + s * dy - y) <= reach;
  });
  return index < 0 ? null : { kind: "wall", index };
}

function binAt({ bins }, x, y) {
  if (y < bins.y) return null;
  const index = bins.edges.findIndex((edge, i) => x >= edge && x < bins.edges[i + 1]);
  return index < 0 ? null : { kind: "bin", index };
}

/** @param {any} board @param {Ref} ref @returns {string} the element in words */
export function describeRef(board, ref) {
  if (ref.refs) return `${group.named(ref)} selected`;
  const { x, y } = placeOf(board, ref);
  const at = `x ${short(x)}, y ${short(y)} m`;
  const { kind, index, end } = ref;
  if (kind === "drop") return `Start at ${at}`;
  if (kind === "peg") return `Peg ${index} of ${board.pegs.length}, ${at}`;
  if (kind === "wall") return `${end ? `End ${end} of wall` : "Wall"} ${index} of ${board.walls.length}, ${at}`;
  if (kind === "edge") return `Edge ${index} of the bins, x ${short(x)} m`;
  return `Bin ${index}, pays ${board.bins.multipliers[index]}`;
}

function short(value) {
  return String(Number(value.toFixed(4))).replace("-", "−");
}

/**
 * The elements that a server's refusal is about.
 * @param {any} board
 * @param {string | null} field "pegs[12].x", "bins.edges[3]", "drop.y"
 * @param {string} detail may name a second element
 * @returns {Ref[]}
 */
export function refsInProblem(board, field, detail) {
  const found = [];
  const add = (ref) => {
    if (holds(board, ref) && !found.some((one) => sameRef(one, ref))) found.push(ref);
  };
  const kinds = { pegs: "peg", walls: "wall", "bins.edges": "edge", "bins.multipliers": "bin" };
  for (const text of [field ?? "", detail]) {
    for (const [, name, index] of text.matchAll(/(pegs|walls|bins\.edges|bins\.multipliers)\[(\d+)\]/g)) {
      add({ kind: kinds[name], index: Number(index) });
    }
  }
  if (/^drop\b/.test(field ?? "")) add({ kind: "drop", index: 0 });
  return found;
}
