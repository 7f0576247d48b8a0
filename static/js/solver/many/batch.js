// Many drops in a worker, so that the page goes on meanwhile: with progress, and an end at any time.

import { startThread } from "./threads.js";

/**
 * @typedef {{board: unknown, first: string, drops: number}} Asked board: its JSON, parsed; first: the
 *   first of the seeds, which count up
 * @typedef {{drops: number, histogram: number[], unsettled: number, time: number}} Tally of the drops
 *   done so far; time: s that all of them fell
 * @typedef {{tally: Tally, error?: undefined} | {error: string, tally?: undefined}} Told
 */

/** One batch under way. */
export class Batch {
  /**
   * @param {Asked} asked
   * @param {(tally: Tally) => void} onProgress
   */
  constructor(asked, onProgress) {
    const { promise, resolve, reject } = deferred();
    /** The tally of all, or of those done when it was cancelled; null if none was. */
    this.done = promise;
    /** @type {Tally | null} */
    let last = null;
    /** @param {string | undefined} reason */
    const fail = (reason) => {
      thread.end();
      reject(new Error(reason || "the worker could not be started"));
    };
    this.cancel = () => {
      thread.end();
      resolve(last);
    };
    const thread = startThread(new URL("worker.js", import.meta.url), (data) => {
      const { tally, error } = /** @type {Told} */ (data);
      if (!tally) {
        fail(error);
        return;
      }
      last = tally;
      onProgress(tally);
      if (tally.drops >= asked.drops) this.cancel();
    }, fail);
    thread.send(asked);
  }
}

function deferred() {
  /** @type {(tally: Tally | null) => void} */
  let resolve = () => {};
  /** @type {(error: Error) => void} */
  let reject = () => {};
  /** @type {Promise<Tally | null>} */
  const promise = new Promise((kept, broken) => {
    resolve = kept;
    reject = broken;
  });
  return { promise, resolve, reject };
}
