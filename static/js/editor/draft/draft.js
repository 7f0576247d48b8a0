// The edited board: its elements, and functions that return a new board with one change. Pure.

import { defaultsOf, evenEdges, sideWalls } from "../../solver/input/values.js";
import { number, t } from "../../texts/text.js";
import { placeOf, withLabels } from "./element.js";
import { named, sameElement } from "./group.js";

/** @import { BallKind, Bins, Board, DropZone, Label, Material, Point } from "../../model/board.js" */
/** @import { ElementRef, Ref } from "./element.js" */

/**
 * @typedef {Partial<Omit<Board, "ball" | "peg_material" | "wall_material" | "bins" | "drop">> & {
 *   ball?: Partial<BallKind>, peg_material?: Partial<Material>, wall_material?: Partial<Material>,
 *   bins?: Partial<Bins>, drop?: Partial<DropZone>}} BoardForm a board with omitted parts
 */

/** A board to start from: three pegs over three bins. @type {Board} */
export const EMPTY = {
  name: t("editor.my-board"), width: 4, height: 3, gravity: 9.81, drag: 0.5,
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
 * The board of a file or a link, with all parts that drawing needs.
 * @param {unknown} form
 * @returns {Board} throws a RangeError that says what is missing or invalid
 */
export function complete(form) {
  if (form === null || typeof form !== "object" || Array.isArray(form)) {
    throw new RangeError(t("editor.not-object"));
  }
  const given = /** @type {BoardForm} */ (form);
  const { x, y, jitter } = defaultsOf("drop");
  const parts = {
    name: "board",
    ...defaultsOf("board"),
    pegs: [],
    ...given,
    ball: { ...defaultsOf("ball"), ...given.ball },
    peg_material: { ...defaultsOf("material"), ...given.peg_material },
    wall_material: { ...defaultsOf("material"), ...given.wall_material },
    drop: { x, y, jitter, ...given.drop },
  };
  const bins = completeBins(given.bins ?? {}, parts);
  /** @type {Board} */
  const board = { ...parts, bins, walls: given.walls ?? sideWalls(bins, parts.drop.y - 2 * parts.ball.radius) };
  const numbers = [board.width, board.height, board.gravity, board.drag, board.ball.radius, board.drop.x, board.drop.y, board.drop.jitter];
  numbers.push(board.drop.reach ?? 0, board.drop.aim ?? 0);
  for (const peg of list(board.pegs, "pegs")) numbers.push(peg?.x, peg?.y, peg?.radius);
  for (const wall of list(board.walls, "walls")) numbers.push(wall?.x1, wall?.y1, wall?.x2, wall?.y2);
  numbers.push(board.bins.y, ...board.bins.edges, ...board.bins.multipliers);
  if (!numbers.every(Number.isFinite)) {
    throw new RangeError(t("editor.not-numbers"));
  }
  return board;
}

/** @param {Partial<Bins>} bins @param {Pick<Board, "width" | "height">} given */
function completeBins(bins, { width, height }) {
  const edges = bins.edges ?? null;
  const count = edges ? edges.length - 1 : Math.max(1, bins.multipliers?.length ?? 1);
  const made = {
    y: bins.y ?? height,
    edges: edges ?? evenEdges(width, count),
    multipliers: bins.multipliers ?? Array(count).fill(1),
  };
  const rises = made.edges.every((edge, i) => i === 0 || edge > made.edges[i - 1]);
  if (count < 1 || !rises || made.multipliers.length !== count
    || (bins.labels?.length || count) !== count) {
    throw new RangeError(t("editor.bad-bins"));
  }
  return withLabels(made, bins.labels);
}

/**
 * @template T
 * @param {T[]} value from a file, so it may be anything
 * @param {string} name
 * @returns {T[]}
 */
function list(value, name) {
  if (!Array.isArray(value)) throw new RangeError(t("editor.no-list", { name }));
  return value;
}

/** @param {Board} board @returns {ElementRef[]} all elements, in the order of the keys for next and previous */
export function refsOf(board) {
  const { pegs, walls, bins } = board;
  /** @param {ElementRef["kind"]} kind @param {unknown[]} items @returns {ElementRef[]} */
  const each = (kind, items) => items.map((_, index) => ({ kind, index }));
  return [
    ...each("drop", [board.drop]),
    ...each("peg", pegs),
    ...each("wall", walls),
    ...each("edge", bins.edges),
    ...each("bin", bins.multipliers),
  ];
}

/** @param {Board} board @param {Ref} ref @returns {boolean} whether the board has this element */
export function holds(board, ref) {
  if (ref.refs) return ref.refs.every((one) => holds(board, one));
  const { pegs, walls, bins } = board;
  const count = {
    drop: 1, peg: pegs.length, wall: walls.length, edge: bins.edges.length, bin: bins.multipliers.length,
  }[ref.kind];
  return ref.index < count;
}

/**
 * @param {Board} board
 * @param {string} path "gravity", "ball.radius", "pegs[3].x", "bins.multipliers[2]"
 * @returns {unknown} the value at the path
 */
export function read(board, path) {
  /** @type {unknown} */
  let part = board;
  for (const step of steps(path)) part = isNode(part) ? part[step] : undefined;
  return part;
}

/** @param {Board} board @param {string} path @param {number | string} value @returns {Board} with this value */
export function written(board, path, value) {
  /** @param {unknown} part @param {string[]} way @returns {unknown} */
  const put = (part, [step, ...rest]) => {
    if (!isNode(part)) throw new RangeError(`a board has no ${path}`);
    const next = rest.length ? put(part[step], rest) : value;
    return Array.isArray(part) ? part.with(Number(step), next) : { ...part, [step]: next };
  };
  const label = /^bins\.labels\[(\d+)\]\.(text|colour)$/.exec(path);
  if (label) return withLabel(board, Number(label[1]), { [label[2]]: String(value) });
  return /** @type {Board} */ (put(board, steps(path)));
}

/**
 * @param {Board} board
 * @param {number} index of a bin
 * @param {Partial<Label>} change an empty text removes the label, an empty colour its colour
 * @returns {Board}
 */
function withLabel(board, index, change) {
  const { labels: old, ...bins } = board.bins;
  const { text = "", colour } = { ...old?.[index], ...change };
  const label = text ? { text, ...(colour ? { colour } : {}) } : null;
  const labels = (old ?? bins.multipliers.map(() => null)).with(index, label);
  return { ...board, bins: withLabels(bins, labels) };
}

/** @param {unknown} part @returns {part is Record<string, unknown>} whether it has parts */
function isNode(part) {
  return typeof part === "object" && part !== null;
}

/** @param {string} path @returns {string[]} */
function steps(path) {
  return path.split(/[.[\]]+/).filter(Boolean);
}

/**
 * @param {number} value
 * @param {number} step
 * @returns {number} the nearest multiple of the step, or the value itself if the step is 0
 */
export function snap(value, step) {
  if (step === 0) return value;
  // Rounded to 12 digits, so that 3 * 0.1 is stored as 0.3.
  return Number((Math.round(value / step) * step).toPrecision(12));
}

/**
 * The element at a place; small elements take precedence over large ones.
 * @param {Board} board
 * @param {number} x metres
 * @param {number} y metres
 * @param {number} reach how far from the element the place may be, m
 * @returns {ElementRef | null}
 */
export function hit(board, x, y, reach) {
  /** @param {Point} place */
  const away = (place) => Math.hypot(place.x - x, place.y - y);
  /** @type {[number, ElementRef][]} the distance of each element, m */
  const found = [];
  board.walls.forEach(({ x1, y1, x2, y2 }, index) => {
    found.push([away({ x: x1, y: y1 }), { kind: "wall", index, end: 1 }]);
    found.push([away({ x: x2, y: y2 }), { kind: "wall", index, end: 2 }]);
  });
  board.pegs.forEach((peg, index) => {
    found.push([away(peg) - peg.radius, { kind: "peg", index }]);
  });
  found.push([away(board.drop) - board.ball.radius, { kind: "drop", index: 0 }]);
  // An edge extends downwards between its bins. A wall that ends at its top takes precedence.
  board.bins.edges.forEach((edge, index) => {
    const below = Math.max(y, board.bins.y);
    found.push([away({ x: edge, y: below }), { kind: "edge", index }]);
  });
  const nearest = found.reduce((best, one) => (one[0] < best[0] ? one : best));
  if (nearest[0] <= reach) return nearest[1];
  return wallAt(board, x, y, reach) ?? binAt(board, x, y);
}

/**
 * @param {Board} board
 * @param {number} x
 * @param {number} y
 * @param {number} reach
 * @returns {ElementRef | null}
 */
function wallAt({ walls }, x, y, reach) {
  const index = walls.findIndex(({ x1, y1, x2, y2 }) => {
    const [dx, dy] = [x2 - x1, y2 - y1];
    const square = dx * dx + dy * dy;
    const s = square ? Math.min(1, Math.max(0, ((x - x1) * dx + (y - y1) * dy) / square)) : 0;
    return Math.hypot(x1 + s * dx - x, y1 + s * dy - y) <= reach;
  });
  return index < 0 ? null : { kind: "wall", index };
}

/** @param {Board} board @param {number} x @param {number} y @returns {ElementRef | null} */
function binAt({ bins }, x, y) {
  if (y < bins.y) return null;
  const index = bins.edges.findIndex((edge, i) => x >= edge && x < bins.edges[i + 1]);
  return index < 0 ? null : { kind: "bin", index };
}

/** @param {Board} board @param {Ref} ref @returns {string} a description of the element */
export function describeRef(board, ref) {
  if (ref.refs) return t("editor.selected", { what: named(ref) });
  const place = placeOf(board, ref);
  const at = { x: short(place.x), y: short(place.y) };
  const { kind, index, end } = ref;
  const { pegs, walls, bins } = board;
  if (kind === "drop") return t("editor.start-at", at);
  if (kind === "peg") return t("editor.peg-at", { index, all: pegs.length, ...at });
  if (kind === "wall" && end) return t("editor.wall-end-at", { end, index, all: walls.length, ...at });
  if (kind === "wall") return t("editor.wall-at", { index, all: walls.length, ...at });
  if (kind === "edge") return t("editor.edge-at", { index, x: at.x });
  return t("editor.bin-pays", { index, pays: bins.multipliers[index] });
}

/** @param {number} value */
function short(value) {
  return number(value, { maximumFractionDigits: 4, useGrouping: false }).replace("-", "−");
}

/**
 * The elements that the server's error is about.
 * @param {Board} board
 * @param {string | null} field "pegs[12].x", "bins.edges[3]", "drop.y"
 * @param {string} detail the error's text, which may name a second element
 * @returns {ElementRef[]}
 */
export function refsInProblem(board, field, detail) {
  /** @type {ElementRef[]} */
  const found = [];
  /** @param {ElementRef} ref */
  const add = (ref) => {
    if (holds(board, ref) && !found.some((one) => sameElement(one, ref))) found.push(ref);
  };
  /** @type {Record<string, ElementRef["kind"]>} */
  const kinds = { pegs: "peg", walls: "wall", "bins.edges": "edge", "bins.multipliers": "bin", "bins.labels": "bin" };
  for (const text of [field ?? "", detail]) {
    for (const [, name, index] of text.matchAll(/(pegs|walls|bins\.edges|bins\.multipliers|bins\.labels)\[(\d+)\]/g)) {
      add({ kind: kinds[name], index: Number(index) });
    }
  }
  if (/^drop\b/.test(field ?? "")) add({ kind: "drop", index: 0 });
  return found;
}
