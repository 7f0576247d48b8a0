// Loads the solver and its digest, for the check of a fair session.

import { openSolver } from "../solver/solver.js";
import { hexOf, sha256 } from "./crypto.js";

/** @import { Tools } from "./check.js" */

/** @returns {Promise<Tools>} */
export async function openTools() {
  const url = new URL("../solver/kernels.wasm", import.meta.url);
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url.href} could not be loaded: HTTP status ${response.status}`);
  const bytes = await response.arrayBuffer();
  return { solver: await openSolver(bytes), kernelDigest: hexOf(await sha256(new Uint8Array(bytes))) };
}
