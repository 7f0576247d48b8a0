// The messages that a room sends to its clients; docs/protocol.md describes each. Types only.

/** @import { BallKind, Bins, Board, Peg, Wall } from "./board.js" */

/**
 * @typedef {{x_min: number, x_max: number, y_min: number, y_max: number}} Extent metres
 * @typedef {{name?: string, colour?: string}} Tag a drop's name and colour, shown to all clients; colour: #rrggbb
 * @typedef {{ball: number, seed: string, x: number, tick: number} & Tag} BallStart
 *
 * @typedef {object} Hello the full state of a room
 * @property {"hello"} type
 * @property {number} protocol
 * @property {string} room
 * @property {string} board_name
 * @property {string} board_digest
 * @property {number | string} physics_version
 * @property {Board} board
 * @property {number[]} slots
 * @property {"independent" | "interacting"} mode
 * @property {number} tick_rate
 * @property {number} tick
 * @property {number} seq how many events the room has sent
 * @property {Extent} extent
 * @property {number} velocity_scale
 * @property {string} stream
 * @property {boolean} [stakes] whether drops may have a stake; missing without a server
 * @property {{balls: number, drops_per_second?: number}} limits
 * @property {BallStart[]} balls
 * @property {{histogram: number[]}} stats
 * @property {string} run
 * @property {string} key
 * @property {{digest: string, weights: number[]}} [draw] in a room that draws its bins with exact odds
 *
 * @typedef {Omit<Hello, "board"> & {board: Board | null, arena: Arena}} ArenaHello in a room
 *   whose balls touch each other; board is null where the balls are in a plain box
 *
 * @typedef {{scene: SceneForm | null, place: StaticGeometry, settings: Settings, paused: boolean,
 *   owned: boolean, balls: BallColumns, presets: Record<string, Record<string, number>>}} Arena
 * @typedef {{walls: Wall[], pegs: Peg[], bins?: Bins | null}} StaticGeometry
 * @typedef {Record<string, number> & {gravity: number, gravity_x: number, drag: number}} Settings of world and
 *   solver, in a room whose balls touch each other
 * @typedef {{ball: number[], radius: number[], density: number[], restitution: number[],
 *   friction: number[]}} BallColumns ball i is ball[i], radius[i], …
 * @typedef {{scene: string, balls: number, seed: string, radii?: number[], width?: number,
 *   height?: number, speed?: number}} SceneForm the scene that the room started with
 *
 * @typedef {object} SignedReceipt the receipt of a drop in a fair session, and its place in the log
 * @property {{session: string, drop: number} & Record<string, unknown>} receipt
 * @property {number} index
 * @property {string} root
 * @property {string} signature
 *
 * @typedef {{type: "accepted", ref?: string | null, explicit_x: boolean, aim?: number,
 *   practice?: boolean, stake?: number, receipt?: SignedReceipt, visitor?: number} & BallStart} Accepted
 * @typedef {{type: "accepted", ref?: string | null, explicit_x?: boolean, x?: number, aim?: number,
 *   practice?: boolean, stake?: number, receipt?: SignedReceipt, visitor?: number} & Omit<BallStart, "x">} BriefAccepted in
 *   the stream `seeds`: x only if it does not follow from the seed
 * @typedef {{visitor: number} & Tag} Visitor
 * @typedef {{type: "presence", here: number, visitors: Visitor[], you?: number}} Presence the visitors of the table
 * @typedef {{type: "clock", tick: number, seq: number}} ClockMessage the room's time
 *
 * @typedef {object} SessionState the current state of a fair session
 * @property {"session"} type
 * @property {string} session
 * @property {Record<string, unknown>} statement what the server committed to
 * @property {string} signature
 * @property {string} key the server's
 * @property {boolean} open
 * @property {number} drops
 * @property {boolean} ended
 * @property {boolean} void the restore of a backup ended it
 * @property {string | null} token secret, sent only to the client that began the session
 *
 * @typedef {{type: "ended", session: string, server_seed: string, statement: {drops: number}}}
 *   SessionEnded
 *
 * @typedef {object} Contact
 * @property {"contact"} type
 * @property {number} ball
 * @property {number} t seconds after the ball's start
 * @property {number} x metres
 * @property {number} y metres
 * @property {number} kind 0 for a peg, 1 for a wall
 * @property {number} index
 * @property {number} speed m/s
 *
 * @typedef {object} Landed
 * @property {"landed"} type
 * @property {number} ball
 * @property {number | null} bin
 * @property {number} score
 * @property {string} [label] the bin's prize, if it has one
 * @property {number} t seconds after the ball's start
 * @property {number} x_end metres
 * @property {string | null} [unsettled]
 * @property {string | null} digest the drop's; null if other balls may have touched the ball
 *
 * @typedef {{type: "landed", ball: number, digest: string}} BriefLanded in the stream `seeds`;
 *   digest: its first digits
 *
 * @typedef {{type: "error", code: string, detail: string, ref?: string | null}} Refusal
 * @typedef {{type: "missed", events: (Accepted | Landed | Contact)[] | null}} Missed
 * @typedef {{number: number, left: number} & Tag} QueueItem balls waiting to be dropped for one person; left: how many
 * @typedef {{type: "queue", waiting: number, paused: boolean, items: QueueItem[]}} QueueState items: only the first of those waiting
 * @typedef {{type: "show"}} ShowChanged the room's show has changed
 * @typedef {{type: "notice", text: string | null, leaving?: boolean}} Notice what the operator announces, and whether the server is about to stop
 * @typedef {{type: "halted", halted: boolean}} Halted whether an operator has stopped the room from accepting drops
 * @typedef {object} SnapshotBall
 * @property {number} id ball id mod 65536
 * @property {number} x metres
 * @property {number} y metres, down
 * @property {number} angle radians, clockwise, within one turn
 * @property {number} vx m/s
 * @property {number} vy m/s
 * @property {boolean} bounced whether the ball hit something since the previous snapshot
 * @property {boolean} asleep whether the ball is at rest, in a room whose balls touch each other
 *
 * @typedef {{tick: number, seq: number, balls: SnapshotBall[]}} Snapshot of a room at one tick; seq: events the room had
 *   sent when this was encoded, modulo 2^32
 *
 * @typedef {Hello | Accepted | BriefAccepted | Contact | Landed | BriefLanded | ClockMessage | Refusal
 *   | Presence | Missed | Halted | Notice | QueueState | ShowChanged | SessionState | SessionEnded} TableMessage
 *
 * @typedef {{type: "placed", ball: number} & BallKind} Placed
 * @typedef {{type: "edited", ball: number | null} & Partial<BallKind>} Edited
 * @typedef {{type: "removed", balls: number[]}} Removed
 * @typedef {{type: "settings", settings: Settings, paused: boolean}} SettingsChange
 * @typedef {{type: "claimed"}} Claimed
 *
 * @typedef {object} Diagnostics
 * @property {"diagnostics"} type
 * @property {number} time s
 * @property {number} kinetic J
 * @property {number} potential J, zero at y = 0
 * @property {number} rotational J
 * @property {number} px kg m/s
 * @property {number} py kg m/s
 * @property {number} angular kg m²/s
 * @property {number} contacts
 * @property {number} penetration the deepest, m
 * @property {number} cell size of the broad phase's smallest cells, m
 * @property {number} asleep
 * @property {number} count balls
 *
 * @typedef {Placed | Accepted | Edited | Removed | Landed | SettingsChange | Claimed | Diagnostics
 *   } ArenaEvent
 * @typedef {ArenaHello | ArenaEvent | Halted | Notice | Refusal} ArenaMessage
 */
