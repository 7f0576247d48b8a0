// Which streams of a room a page asks for, the best first.

export const SEEDS = "seeds"; // no paths at all: the page computes each
const STREAMS = [SEEDS, "segments", "snapshots"];

/**
 * @param {string | null} asked in the page's address
 * @param {boolean} solves whether this page can compute paths
 * @returns {string[]} the streams that will do, the best first
 */
export function streamsFor(asked, solves) {
  const others = STREAMS.filter((stream) => stream !== asked && (solves || stream !== SEEDS));
  return asked === null ? others : [asked, ...others];
}
