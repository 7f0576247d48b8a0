// Runs worker.js on its own thread: a Worker in a page, a worker thread in Node.js.

import { builtin } from "../encoding/beside.js";

/**
 * @typedef {object} Thread
 * @property {(value: unknown) => void} send
 * @property {() => void} end
 */

/** @param {string} name @returns {URL} */
const beside = (name) => new URL(name, import.meta.url);

/**
 * Starts the worker.
 * @param {(value: unknown) => void} hear called with each message of the thread
 * @param {(reason: string) => void} fail called if the thread cannot be started or fails
 * @returns {Thread}
 */
export function startThread(hear, fail) {
  const threads = builtin("node:worker_threads");
  if (threads) {
    const worker = new threads.Worker(beside("worker.js"));
    worker.on("message", hear);
    worker.on("error", (/** @type {Error} */ error) => fail(error.message));
    return { send: (value) => worker.postMessage(value), end: () => worker.terminate() };
  }
  // By exactly this expression, bundlers find the worker and bundle it, too.
  const worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
  worker.addEventListener("message", ({ data }) => hear(data));
  worker.addEventListener("error", ({ message }) => fail(message));
  return { send: (value) => worker.postMessage(value), end: () => worker.terminate() };
}

/**
 * Connects the code of a thread to its owner.
 * @param {(value: unknown) => void} hear called with each message of the owner
 * @returns {(value: unknown) => void} sends a message to the owner
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
