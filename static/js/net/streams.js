// Which streams of a room a page asks for, the best first.

const STREAMS = ["seeds", "segments", "snapshots"];

/**
 * @param {string | null} asked in the page's address
 * @param {boolean} solves whether this page can compute paths
 * @returns {string[]} the streams that will do, the best first
 */
export function streamsFor(asked, solves) {
  const others = STREAMS.filter((stream) => stream !== asked && (solves || stream !== STREAMS[0]));
  return asked === null ? others : [asked, ...others];
}
