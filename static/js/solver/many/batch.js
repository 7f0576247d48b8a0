// A batch of drops computed in a worker, so that the page stays responsive, with progress and `cancel`.

import { startThread } from "./threads.js";

/**
 * @typedef {{board: unknown, first: string, drops: number}} Asked board: its JSON, parsed; first: the
 *   first seed, from which the others count up
 * @typedef {{drops: number, histogram: number[], unsettled: number, time: number}} Tally of the drops
 *   done until now; time: sum of their durations, s
 * @typedef {{tally: Tally, error?: undefined} | {error: string, tally?: undefined}} Told
 */

/** A running batch. */
export class Batch {
  cancel = () => {};

  /**
   * @param {Asked} asked
   * @param {(tally: Tally) => void} onProgress
   */
  constructor(asked, onProgress) {
    /** The final tally; after `cancel` the last one, or null if no drop was done. @type {Promise<Tally | null>} */
    this.done = new Promise((resolve, reject) => {
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
      const thread = startThread((data) => {
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
    });
  }
}
