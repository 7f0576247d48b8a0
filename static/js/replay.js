// One drop again, from its address: the record and its frames, on the same board, at any speed.

import { dropPath, getJson } from "./api.js";
import { emptyScene } from "./board-view.js";
import { Path } from "./path.js";

const FPS = 60;
const PEG = 0;
const LANDING = 5;
const FLASH_SECONDS = 0.35;
const HIT_SECONDS = 1.4;
const TRAIL_POINTS = 14;
const TRAIL_STEP = 1 / 90;
const LOUD = 3; // m/s

/** What the server says of a drop, and the scene at each of its moments. */
export class Replay {
  #trail = new Float64Array(2 * TRAIL_POINTS);

  /** @param {any} board @param {any} record @param {any} sampled the /frames reply */
  constructor(board, record, sampled) {
    this.board = board;
    this.record = record;
    this.duration = record.duration;
    this.path = pathOf(board, record, sampled);
    this.line = this.path.line();
    this.contacts = record.impacts.filter(([, , , , , , kind]) => kind === PEG);
  }

  /**
   * @param {{board: string, seed: string, x: string | null}} drop
   * @returns {Promise<Replay>}
   */
  static async load(drop) {
    const [{ board }, record, sampled] = await Promise.all([
      getJson(`boards/${encodeURIComponent(drop.board)}`),
      getJson(dropPath(drop)),
      getJson(dropPath(drop, "/frames", { fps: String(FPS) })),
    ]);
    return new Replay(board, record, sampled);
  }

  /** Time for the bin's light to fade after the landing, s. */
  get end() {
    return this.duration + HIT_SECONDS;
  }

  /** @param {number} t s @returns {import("./board-view.js").Scene} */
  sceneAt(t) {
    const scene = emptyScene();
    if (t <= this.duration) scene.balls.push(this.#ball(t));
    for (const [since, , , vx, vy, , , index] of this.contacts) {
      const age = (t - since) / FLASH_SECONDS;
      const peg = this.board.pegs[index];
      if (age < 0 || age >= 1) continue;
      scene.flashes.push({ ...peg, age, strength: Math.min(1, Math.hypot(vx, vy) / LOUD) });
    }
    if (t >= this.duration && this.record.bin !== null) {
      const age = Math.min(0.72, (t - this.duration) / HIT_SECONDS);
      scene.hits.push({ bin: this.record.bin, score: this.record.score, age });
      scene.paths.push(this.line);
    }
    return scene;
  }

  #ball(t) {
    const ball = { ...this.path.poseAt(t), mine: true, trail: this.#trail, trailCount: 0 };
    for (let i = 0; i < TRAIL_POINTS && t - i * TRAIL_STEP >= 0; i += 1) {
      const { x, y } = this.path.poseAt(t - i * TRAIL_STEP);
      this.#trail[2 * i] = x;
      this.#trail[2 * i + 1] = y;
      ball.trailCount = i + 1;
    }
    return ball;
  }
}

/** Frames and impacts as one path: between two frames the impacts say where it turned. */
function pathOf(board, record, { fields, frames }) {
  const at = Object.fromEntries(fields.map((name, index) => [name, index]));
  const path = new Path({ gravity: board.gravity, drag: board.drag });
  const moments = frames.map((row) => ({
    t: row[at.t], x: row[at.x], y: row[at.y], angle: row[at.theta],
    vx: row[at.vx], vy: row[at.vy], vIn: true, vOut: true, bounced: false,
  }));
  for (const [t, x, y, vx, vy, , kind] of record.impacts) {
    if (kind === LANDING) continue;
    moments.push({ t, x, y, angle: 0, vx, vy, vIn: false, vOut: true, bounced: false });
  }
  moments.sort((one, two) => one.t - two.t);
  for (const moment of moments) path.add(moment);
  return path;
}
