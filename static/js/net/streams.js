// Which streams a page requests from a room, in order of preference.

export const SEEDS = "seeds"; // without paths: the page computes each
export const PATHS = "paths"; // each path whole, when the ball enters
const STREAMS = [SEEDS, PATHS, "snapshots"];

/**
 * @param {string | null} asked the stream in the page's address
 * @param {boolean} solves whether this page can compute paths
 * @returns {string[]} usable streams, the best first
 */
export function streamsFor(asked, solves) {
  const others = STREAMS.filter((stream) => stream !== asked && (solves || stream !== SEEDS));
  return asked === null ? others : [asked, ...others];
}
