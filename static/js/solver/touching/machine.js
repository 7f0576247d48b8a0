// Loads the engine's kernels for touching balls.

import { bytesOf } from "../encoding/beside.js";
import { Machine } from "../machine.js";

/** @import { Binary } from "../machine.js" */

const KERNELS = new URL("touching.wasm", import.meta.url);

/**
 * @param {Binary} [bytes] of touching.wasm; by default loaded from this module's folder
 * @returns {Promise<Machine>}
 */
export async function loadMachine(bytes) {
  return Machine.open(bytes ?? (await bytesOf(KERNELS)));
}
