// Reads a board's JSON: checks each value's type, range, count and order, and fills in defaults.
//
// The rules for single values are the engine's. The engine also refuses boards on which a ball could
// wedge or miss the bins; this module does not. A drop on such a board ends too, though in no bin.

import { BoardError } from "../errors.js";
import { FORM } from "./form.js";
import { shownJson } from "./json-text.js";
import { isPrintable, textFault } from "./plain-text.js";

/** @import { BallKind, Bins, Board, DropZone, Label, Wall } from "../../model/board.js" */
/** @import { Field } from "./form.js" */

/** @typedef {Record<string, unknown>} Form a JSON object */
/** @typedef {Omit<Board, "drop"> & {drop: Required<DropZone>}} WholeBoard all fields present */
/** @typedef {keyof typeof FORM} Part */

const LEAST_WALL = 1e-6; // m

/** The fields of each part by their names. */
const FIELDS = /** @type {Record<Part, Record<string, Field>>} */ (Object.fromEntries(
  Object.entries(FORM).map(([part, fields]) =>
    [part, Object.fromEntries(fields.map((field) => [field.name, field]))]),
));

/** The defaults of a part that are numbers. @param {Part} part @returns {any} */
export const defaultsOf = (part) => Object.fromEntries(
  Object.values(FIELDS[part]).filter((field) => field.otherwise !== undefined)
    .map(({ name, otherwise }) => [name, otherwise]),
);

const COLOUR = /^#[0-9a-f]{6}$/;

/**
 * @param {unknown} form a board's JSON, parsed
 * @returns {WholeBoard} checked, with defaults filled in; throws a BoardError for an invalid value
 */
export function readBoard(form) {
  const given = known(form, "", namesOf("board"));
  /** @param {string} name */
  const top = (name) => number(given[name], name, FIELDS.board[name]);
  /** @param {string} name @param {Part} part @returns {any} */
  const read = (name, part) => readPart(or(given[name], {}), name, part);
  const [width, height] = [top("width"), top("height")];
  /** @type {BallKind} */
  const ball = read("ball", "ball");
  const bins = readBins(or(given.bins, {}), width, height);
  /** @type {Required<DropZone>} */
  const drop = read("drop", "drop");
  return {
    name: readName(or(given.name, "board")),
    width,
    height,
    gravity: top("gravity"),
    drag: top("drag"),
    ball,
    pegs: rows(or(given.pegs, []), "pegs", most("board", "pegs"), (peg, path) =>
      readPart(peg, path, "peg")),
    peg_material: read("peg_material", "material"),
    walls: given.walls === undefined
      ? sideWalls(bins, drop.y - 2 * ball.radius)
      : rows(given.walls, "walls", most("board", "walls"), readWall),
    wall_material: read("wall_material", "material"),
    bins,
    drop,
  };
}

/**
 * A part of numbers, and of lists of numbers.
 * @param {unknown} value
 * @param {string} path
 * @param {Part} part
 * @returns {any}
 */
function readPart(value, path, part) {
  const form = known(value, path, namesOf(part));
  return Object.fromEntries(Object.values(FIELDS[part]).map((field) => {
    const at = `${path}.${field.name}`;
    const given = form[field.name];
    return [field.name, field.most === undefined ? number(given, at, field)
      : rows(or(given, []), at, field.most, (item, place) => number(item, place, field))];
  }));
}

/** @param {Part} part */
const namesOf = (part) => Object.keys(FIELDS[part]);

/** @param {Part} part @param {string} name */
const most = (part, name) => Number(FIELDS[part][name].most);

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

/**
 * @param {unknown} value undefined if omitted
 * @param {string} path
 * @param {Field} field
 * @returns {number} the value or its default, with 0 in place of -0
 */
function number(value, path, { low = -Infinity, high = Infinity, otherwise }) {
  const given = value === undefined ? otherwise : value;
  if (given === undefined) throw new BoardError(`${path} is missing`, path);
  if (typeof given !== "number") throw fail(path, given, "it must be a number");
  if (!(given >= low && given <= high)) throw fail(path, given, `it must be from ${low} to ${high}`);
  return given + 0;
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
  if (typeof value === "string" && length > 0 && length <= most("board", "name") && isPrintable(value)) {
    return value;
  }
  throw fail("name", value, `a name must be 1 to ${most("board", "name")} printable characters`);
}

/** @param {unknown} value @param {string} path @returns {Wall} */
function readWall(value, path) {
  const wall = readPart(value, path, "wall");
  const [dx, dy] = [wall.x2 - wall.x1, wall.y2 - wall.y1];
  if (dx * dx + dy * dy >= LEAST_WALL * LEAST_WALL) return wall;
  throw new BoardError(
    `${path} from (${wall.x1}, ${wall.y1}) to (${wall.x2}, ${wall.y2}) has no length: its ends must be ` +
    `at least ${LEAST_WALL} m apart`, path,
  );
}

/** @param {unknown} value @param {number} width @param {number} height @returns {Bins} */
function readBins(value, width, height) {
  const form = known(value, "bins", namesOf("bins"));
  const { y, edges: edge, multipliers: payout } = FIELDS.bins;
  const payouts = form.multipliers === undefined ? null
    : list(form.multipliers, "bins.multipliers", most("bins", "multipliers"));
  const edges = form.edges === undefined ? evenEdges(width, Math.max(1, payouts?.length ?? 1))
    : rows(form.edges, "bins.edges", most("bins", "edges"), (item, path) => number(item, path, edge));
  if (edges.length < 2) {
    throw fail("bins.edges", edges, "it needs at least 2 edges, one bin's left and right");
  }
  const wrong = edges.findIndex((x, i) => i > 0 && x <= edges[i - 1]);
  if (wrong > 0) {
    throw fail(`bins.edges[${wrong}]`, edges[wrong], `it must be greater than ${edges[wrong - 1]}`);
  }
  const multipliers = (payouts ?? edges.slice(1).fill(1))
    .map((item, i) => number(item, `bins.multipliers[${i}]`, payout));
  if (multipliers.length !== edges.length - 1) {
    throw new BoardError(
      `bins.multipliers has ${multipliers.length} values: ${edges.length} edges make ` +
      `${edges.length - 1} bins, and each needs one`, "bins.multipliers",
    );
  }
  const labels = readLabels(or(form.labels, []), multipliers.length);
  return { y: number(or(form.y, height), "bins.y", y), edges, multipliers, ...(labels && { labels }) };
}

/** @param {unknown} value @param {number} count of bins @returns {(Label | null)[] | null} null if no bin has a label */
function readLabels(value, count) {
  const labels = rows(value, "bins.labels", most("bins", "labels"), readLabel);
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
  const form = known(value, path, namesOf("label"));
  if (!("text" in form)) throw new BoardError(`${path}.text is missing`, `${path}.text`);
  const text = typeof form.text === "string" ? form.text.normalize("NFC") : "";
  const right = textFault(text, most("label", "text"));
  if (right) throw fail(`${path}.text`, form.text, `it must be ${right}`);
  const colour = form.colour ?? null;
  if (colour === null) return { text };
  if (typeof colour === "string" && COLOUR.test(colour)) return { text, colour };
  throw fail(`${path}.colour`, colour, "it must be # and six digits of 0-9 and a-f");
}

/** @param {number} width @param {number} count */
export function evenEdges(width, count) {
  return Array.from({ length: count + 1 }, (_, i) => (width * (2 * i - count)) / (2 * count) + 0);
}

/** @param {Bins} bins @param {number} top m */
export function sideWalls({ y, edges }, top) {
  if (top >= y) return [];
  return [edges[0], edges[edges.length - 1]].map((x) => ({ x1: x, y1: top, x2: x, y2: y }));
}
