// The default colour of a player, computed from the player's id, so that every page shows the same. Pure.

/** Easy to distinguish from each other, from the player's own ball, and from every table's backdrop. */
export const COLOURS = [
  "#57c7ff", "#86a2ff", "#c08cff", "#ff86d0", "#4fe3b1", "#b9ec52",
  "#ffe169", "#ffb04a", "#8af3f3", "#f3b8a6",
];

/**
 * @param {string} who a public id of the player: a visitor's number, a name or a session
 * @returns {string} #rrggbb, one of COLOURS
 */
export function colourOf(who) {
  // FNV-1a, folded, so that ids that differ only in the last digit get different colours.
  let hash = 0x811c9dc5;
  for (let i = 0; i < who.length; i += 1) hash = Math.imul(hash ^ who.charCodeAt(i), 0x01000193);
  return COLOURS[((hash ^ (hash >>> 16)) >>> 0) % COLOURS.length];
}
