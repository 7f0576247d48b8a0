// Reads a board's JSON: checks each value's type, range, count and order, and fills in defaults.
//
// The rules for single values are the engine's. The engine also refuses boards on which a ball could
// wedge or miss the bins; this module does not. A drop on such a board ends too, though in no bin.

import { BoardError } from "../errors.js";
import { shownJson } from "./json-text.js";
import { isPrintable, textFault } from "./plain-text.js";

/** @import { Bins, Board, DropZone, Label, Material } from "../../model/board.js" */

/** @typedef {Record<string, unknown>} Form a JSON object */
/** @typedef {Omit<Board, "drop"> & {drop: Required<DropZone>}} WholeBoard all fields present */
/** @typedef {{low: number, high: number}} Range */

const FAR = 1e6; // m
const SMALL = 1e-6; // m
const MOST = { pegs: 20_000, walls: 2_000, bins: 1_000, slots: 1_000, name: 100, label: 40 };

/** @type {Record<string, Range>} */
const RANGES = {
  place: { low: -FAR, high: FAR },
  length: { low: 0, high: FAR },
  size: { low: SMALL, high: 2 * FAR },
  radius: { low: SMALL, high: 1e4 },
  gravity: { low: 1e-6, high: 1e4 },
  drag: { low: 0, high: 1e3 },
  density: { low: 1e-9, high: 1e9 },
  restitution: { low: 0, high: 1 },
  friction: { low: 0, high: 10 },
  multiplier: { low: 0, high: 1e9 },
};

const KEYS = ["name", "width", "height", "gravity", "drag", "ball", "pegs", "peg_material", "walls",
  "wall_material", "bins", "drop"];
const COLOUR = /^#[0-9a-f]{6}$/;

/**
 * @param {unknown} form a board's JSON, parsed
 * @returns {WholeBoard} checked, with defaults filled in; throws a BoardError for an invalid value
 */
export function readBoard(form) {
  const given = known(form, "", KEYS);
  const width = number(or(given.width, 8), "width", RANGES.size);
  const height = number(or(given.height, 6), "height", RANGES.size);
  const ball = known(or(given.ball, {}), "ball", ["radius", "density", "restitution", "friction"]);
  const bins = readBins(or(given.bins, {}), width, height);
  const drop = readZone(or(given.drop, {}));
  const radius = number(or(ball.radius, 0.08), "ball.radius", RANGES.radius);
  return {
    name: readName(or(given.name, "board")),
    width,
    height,
    gravity: number(or(given.gravity, 9.81), "gravity", RANGES.gravity),
    drag: number(or(given.drag, 0), "drag", RANGES.drag),
    ball: {
      radius,
      density: number(or(ball.density, 1), "ball.density", RANGES.density),
      ...readMaterial(ball, "ball"),
    },
    pegs: rows(or(given.pegs, []), "pegs", MOST.pegs, readPeg),
    peg_material: readMaterial(
      known(or(given.peg_material, {}), "peg_material", ["restitution", "friction"]), "peg_material",
    ),
    walls: given.walls === undefined
      ? sideWalls(bins, drop.y - 2 * radius)
      : rows(given.walls, "walls", MOST.walls, readWall),
    wall_material: readMaterial(
      known(or(given.wall_material, {}), "wall_material", ["restitution", "friction"]),
      "wall_material",
    ),
    bins,
    drop,
  };
}

/**
 * @param {unknown} value undefined if omitted
 * @param {unknown} otherwise
 */
const or = (value, otherwise) => (value === undefined ? otherwise : value);

/** @param {string} field @param {unknown} value @param {string} wanted says what is valid */
function fail(field, value, wanted) {
  const shown = shownJson(value);
  const text = shown.length > 60 ? `${shown.slice(0, 57)}...` : shown;
  return new BoardError(`${field} is ${text}: ${wanted}`, field);
}

/**
 * @param {unknown} value
 * @param {string} path of the object, "" for the board
 * @param {string[]} keys allowed
 * @returns {Form} the object
 */
function known(value, path, keys) {
  if (typeof value !== "object" || value === null || Array.isArray(value)) {
    throw fail(path || "board", value, "it must be an object");
  }
  const unknown = Object.keys(value).find((key) => !keys.includes(key));
  if (unknown === undefined) return /** @type {Form} */ (value);
  const field = path ? `${path}.${unknown}` : unknown;
  throw new BoardError(`${field} is unknown: ${path || "a board"} has ${keys.join(", ")}`, field);
}

/** @param {Form} form @param {string} path @param {string[]} keys required */
function whole(form, path, keys) {
  const lacking = keys.find((key) => !(key in form));
  if (lacking !== undefined) throw new BoardError(`${path}.${lacking} is missing`, `${path}.${lacking}`);
}

/**
 * @param {unknown} value
 * @param {string} field
 * @param {Range} range
 * @returns {number} the value, with 0 in place of -0
 */
function number(value, field, { low, high } = RANGES.place) {
  if (typeof value !== "number") throw fail(field, value, "it must be a number");
  if (!(value >= low && value <= high)) throw fail(field, value, `it must be from ${low} to ${high}`);
  return value + 0;
}

/** @param {unknown} value @param {string} field @param {number} most @returns {unknown[]} */
function list(value, field, most) {
  if (!Array.isArray(value)) throw fail(field, value, "it must be a list");
  if (value.length <= most) return value;
  throw new BoardError(`${field} has ${value.length} items: at most ${most} are allowed`, field);
}

/**
 * @template T
 * @param {unknown} value
 * @param {string} field
 * @param {number} most
 * @param {(item: unknown, path: string) => T} read
 * @returns {T[]}
 */
function rows(value, field, most, read) {
  return list(value, field, most).map((item, i) => read(item, `${field}[${i}]`));
}

/** @param {unknown} value */
function readName(value) {
  const length = typeof value === "string" ? [...value].length : 0;
  if (typeof value === "string" && length > 0 && length <= MOST.name && isPrintable(value)) {
    return value;
  }
  throw fail("name", value, `a name must be 1 to ${MOST.name} printable characters`);
}

/** @param {Form} form @param {string} path @returns {Material} */
function readMaterial(form, path) {
  return {
    restitution: number(or(form.restitution, 0.6), `${path}.restitution`, RANGES.restitution),
    friction: number(or(form.friction, 0), `${path}.friction`, RANGES.friction),
  };
}

/** @param {unknown} value @param {string} path */
function readPeg(value, path) {
  const form = known(value, path, ["x", "y", "radius"]);
  whole(form, path, ["x", "y", "radius"]);
  return {
    x: number(form.x, `${path}.x`),
    y: number(form.y, `${path}.y`),
    radius: number(form.radius, `${path}.radius`, RANGES.radius),
  };
}

/** @param {unknown} value @param {string} path */
function readWall(value, path) {
  const ends = ["x1", "y1", "x2", "y2"];
  const form = known(value, path, ends);
  whole(form, path, ends);
  const [x1, y1, x2, y2] = ends.map((end) => number(form[end], `${path}.${end}`));
  const [dx, dy] = [x2 - x1, y2 - y1];
  if (dx * dx + dy * dy >= SMALL * SMALL) return { x1, y1, x2, y2 };
  throw new BoardError(
    `${path} from (${x1}, ${y1}) to (${x2}, ${y2}) has no length: its ends must be at least ` +
    `${SMALL} m apart`, path,
  );
}

/** @param {unknown} value @param {number} width @param {number} height @returns {Bins} */
function readBins(value, width, height) {
  const form = known(value, "bins", ["y", "edges", "multipliers", "labels"]);
  const payouts = form.multipliers === undefined ? null
    : list(form.multipliers, "bins.multipliers", MOST.bins);
  const edges = form.edges === undefined ? evenEdges(width, Math.max(1, payouts?.length ?? 1))
    : rows(form.edges, "bins.edges", MOST.bins + 1, (edge, path) => number(edge, path));
  if (edges.length < 2) {
    throw fail("bins.edges", edges, "it needs at least 2 edges, one bin's left and right");
  }
  const wrong = edges.findIndex((edge, i) => i > 0 && edge <= edges[i - 1]);
  if (wrong > 0) {
    throw fail(`bins.edges[${wrong}]`, edges[wrong], `it must be greater than ${edges[wrong - 1]}`);
  }
  const multipliers = (payouts ?? edges.slice(1).fill(1))
    .map((payout, i) => number(payout, `bins.multipliers[${i}]`, RANGES.multiplier));
  if (multipliers.length !== edges.length - 1) {
    throw new BoardError(
      `bins.multipliers has ${multipliers.length} values: ${edges.length} edges make ` +
      `${edges.length - 1} bins, and each needs one`, "bins.multipliers",
    );
  }
  const labels = readLabels(or(form.labels, []), multipliers.length);
  return { y: number(or(form.y, height), "bins.y"), edges, multipliers, ...(labels && { labels }) };
}

/** @param {unknown} value @param {number} count of bins @returns {(Label | null)[] | null} null if no bin has a label */
function readLabels(value, count) {
  const labels = rows(value, "bins.labels", MOST.bins, readLabel);
  if (labels.length > 0 && labels.length !== count) {
    throw new BoardError(
      `bins.labels has ${labels.length} values: there are ${count} bins, and each needs one, ` +
      "which may be null", "bins.labels",
    );
  }
  return labels.some(Boolean) ? labels : null;
}

/** @param {unknown} value @param {string} path @returns {Label | null} */
function readLabel(value, path) {
  if (value === null) return null;
  const form = known(value, path, ["text", "colour"]);
  whole(form, path, ["text"]);
  const text = typeof form.text === "string" ? form.text.normalize("NFC") : "";
  const right = textFault(text, MOST.label);
  if (right) throw fail(`${path}.text`, form.text, `it must be ${right}`);
  const colour = form.colour ?? null;
  if (colour === null) return { text };
  if (typeof colour === "string" && COLOUR.test(colour)) return { text, colour };
  throw fail(`${path}.colour`, colour, "it must be # and six digits of 0-9 and a-f");
}

/** @param {number} width @param {number} count */
function evenEdges(width, count) {
  return Array.from({ length: count + 1 }, (_, i) => (width * (2 * i - count)) / (2 * count) + 0);
}

/** @param {unknown} value @returns {Required<DropZone>} */
function readZone(value) {
  const form = known(value, "drop", ["x", "y", "jitter", "slots", "reach", "aim"]);
  return {
    x: number(or(form.x, 0), "drop.x"),
    y: number(or(form.y, 0), "drop.y"),
    jitter: number(or(form.jitter, 0), "drop.jitter", RANGES.length),
    slots: rows(or(form.slots, []), "drop.slots", MOST.slots, (slot, path) => number(slot, path)),
    reach: number(or(form.reach, 0), "drop.reach", RANGES.length),
    aim: number(or(form.aim, 0), "drop.aim", RANGES.length),
  };
}

/** @param {Bins} bins @param {number} top m */
function sideWalls({ y, edges }, top) {
  if (top >= y) return [];
  return [edges[0], edges[edges.length - 1]].map((x) => ({ x1: x, y1: top, x2: x, y2: y }));
}
