// The surfaces of a board as rows of numbers: first the pegs, then each wall's line and its two ends.

/** @import { Peg, Wall } from "../../model/board.js" */

// Columns of a row; see engine/physics/surface.py.
export const X = 0;
export const Y = 1;
export const DISTANCE = 2; // of a circle: distance of the ball's centre at contact; 0 for a line
export const DISTANCE2 = 3; // of a circle: its square
export const LENGTH = 3; // of a line
export const TX = 4;
export const TY = 5;
const NX = 6;
const NY = 7;
const FIRST_END = 8;
const LAST_END = 9;
const FIRST_LINE = 4; // of a circle: up to four lines that end there
const LINE_SLOTS = 4;
const INVERSE = 8; // of a circle
export const COLUMNS = 10;

/**
 * @param {{pegs: Peg[], walls: Wall[], ball: {radius: number}}} board
 * @returns {Float64Array} rows of COLUMNS; walls with a common end refer to the first one's row of it
 */
export function surfacesOf({ pegs, walls, ball: { radius } }) {
  const items = new Float64Array(COLUMNS * (pegs.length + 3 * walls.length));
  /** @param {number} item */
  const row = (item) => items.subarray(COLUMNS * item, COLUMNS * (item + 1));
  pegs.forEach((peg, i) => setCircle(row(i), peg, radius + peg.radius));
  /** @type {Map<string, number>} */
  const ends = new Map();
  walls.forEach(({ x1, y1, x2, y2 }, w) => {
    const line = pegs.length + 3 * w;
    setLine(row(line), x1, y1, x2 - x1, y2 - y1);
    [{ x: x1, y: y1 }, { x: x2, y: y2 }].forEach((point, which) => {
      const end = line + 1 + which;
      setCircle(row(end), point, radius);
      const place = `${point.x} ${point.y}`;
      const shared = ends.get(place) ?? end;
      ends.set(place, shared);
      row(line)[which ? LAST_END : FIRST_END] = shared;
      const slots = row(shared).subarray(FIRST_LINE, FIRST_LINE + LINE_SLOTS);
      const free = slots.findIndex((slot) => slot < 0);
      if (free >= 0) slots[free] = line;
      if (shared !== end) row(end)[DISTANCE2] = -1; // a copy: never listed as a candidate
    });
  });
  return items;
}

/** @param {Float64Array} row @param {{x: number, y: number}} centre @param {number} distance */
function setCircle(row, { x, y }, distance) {
  row.set([x, y, distance, distance * distance]);
  row.fill(-1, FIRST_LINE, FIRST_LINE + LINE_SLOTS);
  row[INVERSE] = 1 / distance;
}

/**
 * @param {Float64Array} row
 * @param {number} x
 * @param {number} y
 * @param {number} dx from its first end to its last, m
 * @param {number} dy
 */
function setLine(row, x, y, dx, dy) {
  const length = Math.sqrt(dx * dx + dy * dy);
  row.set([x, y, 0, length]);
  row[TX] = dx / length;
  row[TY] = dy / length;
  row[NX] = -dy / length;
  row[NY] = dx / length;
}
