// What a player reads when who runs the server halts the table, or lets it go on.

/** @param {boolean} halted @returns {string} */
export function haltedWords(halted) {
  return halted
    ? "This table is paused: it takes no drops now. Balls in flight land and are paid."
    : "This table takes drops again.";
}
