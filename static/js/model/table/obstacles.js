// Pegs and walls of a board, searched by place: whether they stop a ball on its way. Pure.

/** @import { Board, Peg, Wall } from "../board.js" */

// In radii of the ball: this far inside a peg is more than contact and rounding explain.
const DEEP = 0.3;

const COLUMN = 1 << 20; // cells in one column: a cell's key is column * COLUMN + row

/** Pegs in the cells of a grid, walls in a list: boards have many pegs and few walls. */
export class Obstacles {
  /** @type {Map<number, Peg[]>} */
  #cells = new Map();

  /** @param {Board} board */
  constructor({ pegs, walls, ball }) {
    this.walls = walls;
    this.radius = ball.radius;
    this.reach = pegs.reduce((most, { radius }) => Math.max(most, radius), 0) + ball.radius;
    for (const peg of pegs) {
      const key = this.#key(peg.x, peg.y, 0, 0);
      const cell = this.#cells.get(key);
      if (cell) cell.push(peg);
      else this.#cells.set(key, [peg]);
    }
  }

  /**
   * @param {number} fromX
   * @param {number} fromY
   * @param {number} x
   * @param {number} y
   * @returns {boolean} whether a peg or wall stops a ball that flies from one place to the other
   */
  stop(fromX, fromY, x, y) {
    return this.#inPeg(x, y) || this.walls.some((wall) => crosses(wall, fromX, fromY, x, y));
  }

  /** @param {number} x @param {number} y */
  #inPeg(x, y) {
    for (let across = -1; across <= 1; across += 1) {
      for (let down = -1; down <= 1; down += 1) {
        for (const peg of this.#cells.get(this.#key(x, y, across, down)) ?? []) {
          const near = peg.radius + (1 - DEEP) * this.radius;
          if ((x - peg.x) ** 2 + (y - peg.y) ** 2 < near * near) return true;
        }
      }
    }
    return false;
  }

  /** @param {number} x @param {number} y @param {number} across @param {number} down */
  #key(x, y, across, down) {
    return (Math.floor(x / this.reach) + across) * COLUMN + Math.floor(y / this.reach) + down;
  }
}

/**
 * Whether the straight line from (ax, ay) to (bx, by) crosses a wall.
 * @param {Wall} wall
 * @param {number} ax
 * @param {number} ay
 * @param {number} bx
 * @param {number} by
 */
function crosses({ x1, y1, x2, y2 }, ax, ay, bx, by) {
  /** @param {number} x @param {number} y */
  const side = (x, y) => (x2 - x1) * (y - y1) - (y2 - y1) * (x - x1);
  /** @param {number} x @param {number} y */
  const other = (x, y) => (bx - ax) * (y - ay) - (by - ay) * (x - ax);
  return side(ax, ay) * side(bx, by) < 0 && other(x1, y1) * other(x2, y2) < 0;
}
