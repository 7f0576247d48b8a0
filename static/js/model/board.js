// The board's JSON form as types, where a ball may start, and which walls are the board's sides. Pure.

/**
 * Lengths in metres, y downwards; densities in kg/m², drag in 1/s, gravity in m/s².
 *
 * @typedef {{x: number, y: number}} Point
 * @typedef {{restitution: number, friction: number}} Material
 * @typedef {Material & {radius: number, density: number}} BallKind
 * @typedef {Point & {radius: number}} Peg
 * @typedef {{x1: number, y1: number, x2: number, y2: number}} Wall
 * @typedef {{text: string, colour?: string}} Label the prize in a bin; colour: #rrggbb
 * @typedef {{y: number, edges: number[], multipliers: number[], labels?: (Label | null)[]}} Bins
 * @typedef {Point & {jitter: number, reach?: number, aim?: number, slots?: number[]}} DropZone where balls
 *   start: within `jitter` of x, or of the player's aim. An aim is one of the slots, or at most `aim` from x
 *
 * @typedef {object} Board
 * @property {string} name
 * @property {number} width
 * @property {number} height
 * @property {number} gravity
 * @property {number} drag
 * @property {BallKind} ball
 * @property {Peg[]} pegs
 * @property {Material} peg_material
 * @property {Wall[]} walls
 * @property {Material} wall_material
 * @property {Bins} bins
 * @property {DropZone} drop
 */

/** @param {Pick<Board, "bins">} board @param {number | null} bin @returns {Label | null} */
export const labelOf = ({ bins: { labels } }, bin) => (bin === null ? null : labels?.[bin] ?? null);

/** @param {Pick<DropZone, "jitter" | "reach">} drop @returns {number} how far from the zone's x a ball may start, m */
export const startSpan = ({ jitter, reach = 0 }) => Math.max(jitter, reach);

/**
 * @param {Pick<DropZone, "jitter" | "reach" | "aim">} drop
 * @returns {number} how far from the zone's x a player may aim, m: the start that the seed draws around
 *   the aim stays inside the zone
 */
export const aimSpan = (drop) => Math.min(drop.aim ?? 0, startSpan(drop) - drop.jitter);

/**
 * The aim nearest to x that the board allows.
 * @param {{drop: Pick<DropZone, "x" | "jitter" | "reach" | "aim">}} board
 * @param {number[]} slots the only places that may be aimed at; empty where any place may
 * @param {number} x metres
 * @returns {number} metres
 */
export function allowedAim(board, slots, x) {
  if (slots.length) {
    return slots.reduce((best, slot) => (Math.abs(slot - x) < Math.abs(best - x) ? slot : best));
  }
  const middle = board.drop.x;
  const span = aimSpan(board.drop);
  // Tenths of a millimetre keep links short; truncation keeps the value inside the range.
  const offset = Math.max(-span, Math.min(span, x - middle));
  return middle + Math.trunc(offset * 1e4) / 1e4;
}

/**
 * Which walls are the board's sides: the rails of a side are painted outside of it. A side is a chain of
 * walls with common ends that leads down to an outer end of the bins, or past it.
 * app/render/parts/board.py does the same for pictures.
 * @param {Pick<Board, "walls" | "bins" | "ball" | "drop">} board
 * @returns {number[]} for each wall: -1 on the left side, 1 on the right side, 0 inside the board
 */
export function sidesOf(board) {
  const { walls, drop } = board;
  /** @type {number[]} */
  const found = walls.map(() => 0);
  for (const chain of chainsOf(walls)) {
    const ends = new Set(chain.map((number) => endReached(board, walls[number])).filter(Boolean));
    const [only] = ends;
    for (const number of chain) {
      const { x1, x2 } = walls[number];
      if (ends.size > 0) found[number] = ends.size === 1 ? only : Math.sign(x1 + x2 - 2 * drop.x);
    }
  }
  return found;
}

/**
 * The outer end of the bins (-1 left, 1 right) that a wall reaches to within a ball's radius, or 0.
 * @param {Pick<Board, "bins" | "ball">} board
 * @param {Wall} wall
 */
function endReached({ bins: { y, edges }, ball: { radius } }, { x1, y1, x2, y2 }) {
  const [top, bottom] = y1 < y2 || (y1 === y2 && x1 <= x2)
    ? [{ x: x1, y: y1 }, { x: x2, y: y2 }] : [{ x: x2, y: y2 }, { x: x1, y: y1 }];
  if (y < top.y || y > bottom.y + radius) return 0;
  const part = bottom.y > top.y ? Math.min((y - top.y) / (bottom.y - top.y), 1) : 1;
  const x = top.x + part * (bottom.x - top.x);
  return Number(x >= edges[edges.length - 1] - radius) - Number(x <= edges[0] + radius);
}

/** @param {Wall[]} walls @returns {number[][]} the numbers of the walls in each chain, which share their ends */
function chainsOf(walls) {
  /** @type {Map<string, number[]>} */
  const meeting = new Map();
  const endsOf = (/** @type {number} */ number) => {
    const { x1, y1, x2, y2 } = walls[number];
    return [`${x1},${y1}`, `${x2},${y2}`];
  };
  walls.forEach((_, number) => {
    for (const end of endsOf(number)) meeting.set(end, [...(meeting.get(end) ?? []), number]);
  });
  const left = new Set(walls.keys());
  const chains = [];
  for (const first of left) {
    left.delete(first);
    const chain = [first];
    for (const number of chain) { // the loop also visits the walls that it appends
      for (const other of endsOf(number).flatMap((end) => meeting.get(end) ?? [])) {
        if (left.delete(other)) chain.push(other);
      }
    }
    chains.push(chain);
  }
  return chains;
}
