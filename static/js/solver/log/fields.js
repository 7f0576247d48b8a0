// The fields of a room's log, as in app/rooms/drop_format.py. Generated: do not edit, but run
// python -m tools.log_fields
export const NEEDED = ["version", "board", "board_digest", "mode", "solver", "tick_rate", "physics_version", "tick", "drops", "world_digest", "digest"];
export const OPTIONAL = ["kind", "room"];
export const ENTRY = ["ball", "tick", "seed", "result"];
export const ENTRY_OPTIONAL = ["x", "aim", "stake", "who", "practice", "name", "colour"];
export const RESULT = ["tick", "bin", "score", "t", "x_end", "digest", "unsettled", "payout"];
export const UNCOVERED = ["name", "colour"];
