// The colour of a player who has chosen none: the same on every screen, by who it is alone. Pure.

/** Told apart from each other, from one's own ball and from every table's ground. */
export const COLOURS = [
  "#57c7ff", "#86a2ff", "#c08cff", "#ff86d0", "#4fe3b1", "#b9ec52",
  "#ffe169", "#ffb04a", "#8af3f3", "#f3b8a6",
];

/**
 * @param {string} who what a player is known by to all: a member's mark, or else a session
 * @returns {string} #rrggbb, one of COLOURS
 */
export function colourOf(who) {
  // FNV-1a, folded: ids that differ in their last digit alone get colours that differ.
  let hash = 0x811c9dc5;
  for (let i = 0; i < who.length; i += 1) hash = Math.imul(hash ^ who.charCodeAt(i), 0x01000193);
  return COLOURS[((hash ^ (hash >>> 16)) >>> 0) % COLOURS.length];
}
