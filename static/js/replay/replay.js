// Replays a drop: loads or computes its record and states, and makes the scene at any time.

import { Motion, samplesNeeded, upTo } from "../model/motion/drop.js";
import { PEG } from "../model/motion/kinds.js";
import { MAIN_BOARD } from "../model/presets.js";
import { emptyScene } from "../model/scene.js";
import { ApiError, getJson, getText, postJson } from "../net/api.js";
import { boardInHash, unpackBoard } from "../net/board-link.js";
import { dropPath } from "../net/drop-address.js";
import { t } from "../texts/text.js";
import { say } from "../util/dom.js";

/** @import { Board } from "../model/board.js" */
/** @import { Certificate } from "../model/certificate.js" */
/** @import { Scene } from "../model/scene.js" */
/** @import { DropAddress } from "../net/drop-address.js" */
/** @import { State } from "../model/motion/flight.js" */
/** @import { DropRecord, Sampled } from "../model/motion/drop.js" */
/** @import { BoardReply } from "../net/replies.js" */
/** @import { Key } from "../texts/text.js" */

const DEFAULT_SEED = "42"; // if the address names none
const FLASH_SECONDS = 0.35;
const HIT_SECONDS = 1.4;
const PATH_RATE = 120; // points a second of the drawn path
const TRAIL_POINTS = 14;
const TRAIL_STEP = 1 / 90;
const LOUD = 3; // m/s

/** The code that computes drops; null if it cannot be fetched. */
const solverCode = () => import("./compute.js").catch(() => null);

/** A drop's record, and its scene at any time. */
export class Replay {
  /** @type {State[] | null} */
  #path = null;

  /**
   * @param {Board} board
   * @param {DropRecord} record
   * @param {string | null} text the record as the server sent it; null if this page computed it
   * @param {Sampled} sampled
   */
  constructor(board, record, text, sampled) {
    this.board = board;
    this.record = record;
    this.text = text;
    this.motion = new Motion(board, record, sampled);
    this.duration = record.duration;
  }

  /**
   * Loads a drop from the server, whose records say more; if the server does not answer, this page computes it.
   * @param {Board} board
   * @param {DropAddress} drop
   * @returns {Promise<Replay>}
   */
  static async load(board, drop) {
    try {
      return await Replay.#fetched(board, drop);
    } catch (error) {
      const computed = isSilence(error) ? await Replay.#computed(board, drop) : null;
      if (computed) return computed;
      throw error;
    }
  }

  /**
   * Computes a drop in this page, or loads it from the server if this page cannot compute it.
   * @param {Board} board
   * @param {DropAddress} drop
   * @returns {Promise<Replay>}
   */
  static async compute(board, drop) {
    return (await Replay.#computed(board, drop)) ?? Replay.#fetched(board, drop);
  }

  /** @param {Board} board @param {DropAddress} drop @returns {Promise<Replay | null>} */
  static async #computed(board, drop) {
    const code = await solverCode();
    const found = await code?.computeDrop(board, drop);
    return found ? new Replay(board, found.record, null, found.sampled) : null;
  }

  /** @param {Board} board @param {DropAddress} drop @returns {Promise<Replay>} */
  static async #fetched(board, drop) {
    // The certainty of the bin is computed only for the exact solver.
    const query = new URLSearchParams(drop.solver === "stepped" ? {} : { certainty: "true" });
    const text = await getText(dropPath(drop, "", query));
    const record = /** @type {DropRecord} */ (JSON.parse(text));
    const fps = String(samplesNeeded(record));
    const sampled = await getJson(dropPath(drop, "/frames", new URLSearchParams({ fps })));
    return new Replay(board, record, text, /** @type {Sampled} */ (sampled));
  }

  /** The whole path. */
  get path() {
    this.#path ??= this.motion.line(0, this.duration, PATH_RATE);
    return this.#path;
  }

  /** @param {number} t s @returns {State[]} the path up to t */
  pathTo(t) {
    return upTo(this.path, this.motion.stateAt(Math.min(t, this.duration)));
  }

  /** When the bin's light has faded after the landing, s. */
  get end() {
    return this.duration + HIT_SECONDS;
  }

  /**
   * Adds this drop's ball, flashes and lit bin to a scene.
   * @param {Scene} scene
   * @param {number} t s
   * @param {boolean} [mine] whether to draw the ball as the player's own
   */
  addTo(scene, t, mine = true) {
    // A landed ball disappears into its bin. A ball at rest elsewhere remains visible.
    const stays = this.record.bin === null;
    if (t <= this.duration || stays) scene.balls.push(this.#ball(Math.min(t, this.duration), mine));
    for (const { t: since, after, index } of this.motion.hits.filter(({ kind }) => kind === PEG)) {
      const age = (t - since) / FLASH_SECONDS;
      if (age < 0 || age >= 1) continue;
      const strength = Math.min(1, Math.hypot(after.vx, after.vy) / LOUD);
      scene.flashes.push({ ...this.board.pegs[index], age, strength });
    }
    if (t >= this.duration && this.record.bin !== null) {
      const age = Math.min(0.72, (t - this.duration) / HIT_SECONDS);
      scene.hits.push({ bin: this.record.bin, score: this.record.score, age });
    }
  }

  /** @param {number} t s @returns {Scene} */
  sceneAt(t) {
    const scene = emptyScene();
    this.addTo(scene, t);
    return scene;
  }

  /** @param {number} t @param {boolean} mine */
  #ball(t, mine) {
    const { x, y, theta } = this.motion.stateAt(t);
    const times = Array.from({ length: TRAIL_POINTS }, (_, i) => t - i * TRAIL_STEP);
    const trail = times.filter((then) => then >= 0).map((then) => this.motion.stateAt(then));
    return { x, y, angle: theta, mine, trail };
  }
}

/**
 * The drop that the page's address names. A board in the fragment is registered, so that the server can
 * compute drops on it.
 * @param {DropAddress} asked missing values are replaced by defaults
 * @returns {Promise<{board: Board, drop: DropAddress}>}
 */
export async function dropOf(asked) {
  // A new fragment is another board, but does not reload the page by itself.
  window.addEventListener("hashchange", () => window.location.reload());
  const { board, address } = await boardOf(asked.board || MAIN_BOARD, window.location.hash);
  return { board, drop: { ...asked, board: address, seed: asked.seed || DEFAULT_SEED } };
}

/** @param {string} name a preset's name or a digest @param {string} hash */
async function boardOf(name, hash) {
  const packed = boardInHash(hash);
  if (packed === null) {
    const { board } = /** @type {BoardReply} */ (await getJson(`boards/${encodeURIComponent(name)}`));
    return { board, address: name };
  }
  const form = await unpackBoard(packed);
  try {
    const { board, digest } = /** @type {BoardReply} */ (await postJson("boards", form));
    return { board, address: digest };
  } catch (error) {
    const code = isSilence(error) ? await solverCode() : null;
    const read = await code?.readForm(form);
    if (!read) throw error;
    return read;
  }
}

/**
 * Has the server prove where drops land, and shows the result.
 * @param {DropAddress[]} drops @param {HTMLElement} note @param {Key} asking text shown meanwhile
 * @param {(certificates: Certificate[]) => ["" | "good" | "bad", string]} told
 */
export async function prove(drops, note, asking, told) {
  say(note, "", t(asking));
  const query = new URLSearchParams({ certified: "true" });
  try {
    const proven = await Promise.all(drops.map((drop) => getJson(dropPath(drop, "", query))));
    say(note, ...told(/** @type {{certificate: Certificate}[]} */ (proven).map(({ certificate }) => certificate)));
  } catch (error) {
    if (!(error instanceof ApiError)) throw error;
    say(note, "bad", error.message);
  }
}

/** @param {unknown} error @returns {boolean} whether the server did not answer */
function isSilence(error) {
  return error instanceof ApiError && error.status === 0;
}
