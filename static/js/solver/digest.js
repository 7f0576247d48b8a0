// Digests of boards and drops: SHA-256 of the same canonical bytes as in engine/board/digest.py and
// engine/drops/digest.py.

import { Bytes } from "./encoding/bytes.js";
import { sha256 } from "./encoding/sha256.js";

/** @import { Label, Material } from "../model/board.js" */
/** @import { WholeBoard } from "./input/values.js" */
/** @import { Traced } from "./kernels.js" */

export const PHYSICS_VERSION = 6;
const EXACT = 0;

/** @param {WholeBoard} board @returns {string} 64 hexadecimal digits */
export function boardDigest(board) {
  const { ball, bins, drop } = board;
  const out = new Bytes();
  out.text("plinko-board/1\n");
  measured(out, board.name);
  out.floats([board.width, board.height, board.gravity, board.drag]);
  out.floats([ball.radius, ball.density, ball.restitution, ball.friction]);
  out.word(board.pegs.length);
  out.floats(board.pegs.flatMap(({ x, y, radius }) => [x, y, radius]));
  out.floats(pair(board.peg_material));
  out.word(board.walls.length);
  out.floats(board.walls.flatMap(({ x1, y1, x2, y2 }) => [x1, y1, x2, y2]));
  out.floats(pair(board.wall_material));
  out.floats([bins.y]);
  for (const values of [bins.edges, bins.multipliers]) counted(out, values);
  out.floats([drop.x, drop.y, drop.jitter]);
  counted(out, drop.slots);
  if (drop.aim !== 0 || bins.labels) out.floats([drop.reach, drop.aim]);
  else if (drop.reach !== 0) out.floats([drop.reach]);
  if (bins.labels) labelled(out, bins.labels);
  return sha256(out.written);
}

/** @param {Material} material */
const pair = ({ restitution, friction }) => [restitution, friction];

/** @param {Bytes} out @param {string} text */
function measured(out, text) {
  const bytes = new Bytes();
  out.word(bytes.text(text));
  out.bytes(bytes.written);
}

/** @param {Bytes} out @param {(Label | null)[]} labels */
function labelled(out, labels) {
  out.word(labels.length);
  for (const label of labels) {
    measured(out, label?.text ?? "");
    measured(out, label?.colour ?? "");
  }
}

/** @param {Bytes} out @param {number[]} values */
function counted(out, values) {
  out.word(values.length);
  out.floats(values);
}

/**
 * @param {string} board its digest
 * @param {{x: number, y: number}} start at rest, m
 * @param {Pick<Traced, "outcome" | "impacts">} traced
 * @returns {string} 64 hexadecimal digits
 */
export function dropDigest(board, { x, y }, { outcome, impacts }) {
  const out = new Bytes();
  out.text("plinko drop");
  out.hex(board);
  out.word(PHYSICS_VERSION);
  out.bytes([EXACT]);
  out.floats([x, y, 0, 0, 0]);
  out.bytes([outcome]);
  out.long(impacts.length);
  for (const row of impacts) {
    out.floats(row.slice(0, 6));
    out.word(row[6]);
    out.word(row[7]);
  }
  return sha256(out.written);
}
