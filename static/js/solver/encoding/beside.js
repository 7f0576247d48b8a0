// Loads files that lie next to a module: by fetch in a page or a worker, from disk in Node.js, whose
// fetch cannot read files.

/** @import { Binary } from "../machine.js" */

/**
 * A built-in module of Node.js; null outside of Node.js.
 * @param {string} name
 */
export function builtin(name) {
  return /** @type {any} */ (globalThis).process?.getBuiltinModule?.(name) ?? null;
}

/** @param {URL} url @returns {Promise<Binary>} */
export async function bytesOf(url) {
  const files = url.protocol === "file:" ? builtin("node:fs/promises") : null;
  if (files) return files.readFile(url);
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url.href} could not be loaded: HTTP status ${response.status}`);
  return response.arrayBuffer();
}
