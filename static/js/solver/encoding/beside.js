// Files beside a module: fetched in a page or a worker, read in Node.js, whose fetch has no files.

/**
 * A module of Node.js's own; null elsewhere.
 * @param {string} name
 */
export function builtin(name) {
  return /** @type {any} */ (globalThis).process?.getBuiltinModule?.(name) ?? null;
}

/** @param {URL} url @returns {Promise<BufferSource>} */
export async function bytesOf(url) {
  const files = url.protocol === "file:" ? builtin("node:fs/promises") : null;
  if (files) return files.readFile(url);
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url.href} is not there: ${response.status}`);
  return response.arrayBuffer();
}
