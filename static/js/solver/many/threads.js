// A thread of its own for a module: a Worker in a page, a worker thread in Node.js.

import { builtin } from "../encoding/beside.js";

/**
 * @typedef {object} Thread
 * @property {(value: unknown) => void} send
 * @property {() => void} end
 */

/**
 * Start a module on a thread of its own.
 * @param {URL} url
 * @param {(value: unknown) => void} hear what it tells
 * @param {(reason: string) => void} fail when it cannot be started, or breaks
 * @returns {Thread}
 */
export function startThread(url, hear, fail) {
  const threads = builtin("node:worker_threads");
  if (threads) {
    const worker = new threads.Worker(url);
    worker.on("message", hear);
    worker.on("error", (/** @type {Error} */ error) => fail(error.message));
    return { send: (value) => worker.postMessage(value), end: () => worker.terminate() };
  }
  const worker = new Worker(url, { type: "module" });
  worker.addEventListener("message", ({ data }) => hear(data));
  worker.addEventListener("error", ({ message }) => fail(message));
  return { send: (value) => worker.postMessage(value), end: () => worker.terminate() };
}

/**
 * From within a thread: hear its owner, and get what tells the owner something.
 * @param {(value: unknown) => void} hear
 * @returns {(value: unknown) => void}
 */
export function hearOwner(hear) {
  const port = builtin("node:worker_threads")?.parentPort;
  if (port) {
    port.on("message", hear);
    return (value) => port.postMessage(value);
  }
  addEventListener("message", ({ data }) => hear(data));
  return (value) => postMessage(value);
}
