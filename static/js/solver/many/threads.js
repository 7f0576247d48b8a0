// Runs a module on its own thread: a Worker in a page, a worker thread in Node.js.

import { builtin } from "../encoding/beside.js";

/**
 * @typedef {object} Thread
 * @property {(value: unknown) => void} send
 * @property {() => void} end
 */

/**
 * Starts a module on its own thread.
 * @param {URL} url
 * @param {(value: unknown) => void} hear called with each message of the thread
 * @param {(reason: string) => void} fail called if the thread cannot be started or fails
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
