"""The ledger's rows and writes as frozen values: a board, a room run, a drop, a result."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from plinko.app.protocol.messages import SignedReceipt
from plinko.app.protocol.visitors import NO_TAG, Tag
from plinko.app.rooms.keys import IdempotencyKey
from plinko.app.rooms.pending import DropCommand


@dataclass(frozen=True, slots=True)
class BoardRow:
    """A board, identified by its digest."""

    digest: str
    name: str
    json: str


@dataclass(frozen=True, slots=True)
class DrawRow:
    """A room's draw, identified by its digest."""

    digest: str
    json: str


@dataclass(frozen=True, slots=True)
class StoredBasis:
    """The board (or scene) and the draw of a room run, as the ledger's JSON.

    None if the ledger lacks it; `draw` also if the run has none.
    """

    board: str | None
    draw: str | None


@dataclass(frozen=True, slots=True)
class RoomRow:
    """A room run: one world of the room `id` from tick 0 on. No other run has its `number`.

    board: the digest of its board or scene; draw: that of its draw, if it has one.
    tick: of the last mark.
    checkpoint: for touching balls, the world after `checkpoint_drops` inputs, from which a replay
    starts; None stands for the world at tick 0.
    opened, used, closed: Unix times in s; the run began at `opened`.
    creator: identifies who opened it, if rooms are counted per creator.
    rules: of the release that began it; see RULES.
    pruned: drops below this number are deleted.
    """

    number: int
    id: str
    board: str
    mode: str
    owned: bool
    tick_rate: int
    physics_version: int
    opened: float
    used: float
    awake: bool = False
    tick: int = 0
    checkpoint: bytes | None = None
    checkpoint_drops: int = 0
    closed: float | None = None
    creator: str | None = None
    draw: str | None = None
    rules: int = 2
    pruned: int = 0


RULES: Final = 2
"""In a run of rules 2, a table's tick is its clock. In one of rules 1, of release 1.0, it stood
still while no ball moved. A table's run of rules 1 ends at its next use; its balls land first."""


@dataclass(frozen=True, slots=True)
class ListedRoom:
    """An open room in the ledger, with the fields that a list of rooms shows."""

    number: int
    id: str
    board_name: str
    board: str
    mode: str
    tick: int
    drops: int
    used: float
    awake: bool


@dataclass(frozen=True, slots=True)
class DropRow:
    """A fact: ball number `ball` of its room run starts at `tick`. It never changes.

    The ball's whole flight follows from it. x, aim: in m, if the player chose one. stake: in minor
    units. name, colour: its tag.
    """

    room: int
    ball: int
    tick: int
    seed: int
    x: float | None = None
    stake: int = 0
    who: str | None = None
    aim: float | None = None
    practice: bool = False
    name: str | None = None
    colour: str | None = None

    @classmethod
    def of(cls, run: int, ball: int, tick: int, command: DropCommand) -> "DropRow":
        drawn = (command.seed, command.x, command.stake, command.who, command.aim)
        return cls(run, ball, tick, *drawn, command.practice, **command.tag.fields)

    @property
    def tag(self) -> Tag:
        return Tag(self.name, self.colour) if self.name or self.colour else NO_TAG

    @property
    def number(self) -> int:
        return self.ball


@dataclass(frozen=True, slots=True)
class InputRow:
    """Input `number` of a room whose balls touch each other, as JSON, carried out at `tick`."""

    room: int
    number: int
    tick: int
    data: str
    who: str | None = None


@dataclass(slots=True, eq=False)
class SessionTurn:
    """What the writer needs for the next drop of a fair session.

    seed_of: the seed of drop n. receipt: the receipt of a drop, whose tick and ball are known.
    most: drops that a session may have. `n` is set by the writer.
    """

    session: str
    most: int
    seed_of: Callable[[int], int]
    leaf: "Callable[[int, DropRow], LogLeaf]"
    n: int = -1


@dataclass(slots=True, eq=False)
class NewDrop:
    """A drop to write: the writer's turn makes the fact, with its number, tick, seed and receipt.

    tick: the earliest. A session's turn replaces the seed of the command. After the commit, either
    `error` says why there is no fact, or `fact` is set; with `earlier`, a request with the same key
    had made it before, and `result` is its result, if known.
    """

    room: int
    tick: int
    command: DropCommand
    used: float
    key: IdempotencyKey | None = None
    session: SessionTurn | None = None
    fact: DropRow | None = None
    receipt: SignedReceipt | None = None
    result: "ResultRow | None" = None
    earlier: bool = False
    error: Exception | None = None


@dataclass(slots=True, eq=False)
class NewInput:
    """An input of touching balls to write; the writer's turn gives it its `number`, or `error`."""

    room: int
    tick: int
    data: str
    who: str | None = None
    key: IdempotencyKey | None = None
    number: int = -1
    error: Exception | None = None


@dataclass(frozen=True, slots=True)
class TableState:
    """What the ledger has of a table.

    drops: number of its drops. last: tick of the last one. rest: tick of the latest landing among
    the last results. sums: the number of results by bin, None for balls that did not land. flying:
    the drops without a result.
    """

    drops: int
    last: int
    rest: int
    sums: dict[int | None, int]
    flying: list[DropRow]


@dataclass(frozen=True, slots=True)
class ResultRow:
    """The result of a drop; `digest` covers its whole path, `payout` is in minor units."""

    room: int
    ball: int
    tick: int
    bin: int | None
    score: float
    t: float
    x_end: float
    digest: str
    unsettled: str | None
    payout: int = 0


TakenRow = DropRow | InputRow
"""The row of an input: a drop of independent balls, or an input to touching balls."""


@dataclass(frozen=True, slots=True)
class QueueRow:
    """The queue of the room run `room`, as JSON; replaces the previous row."""

    room: int
    data: str


@dataclass(frozen=True, slots=True)
class ShowRow:
    """The show of the room with this id, as JSON, at a Unix time in s; replaces the former row."""

    room: str
    data: str
    updated: float


@dataclass(slots=True, eq=False)
class Prune:
    """Delete some rows that are older than `before`, a Unix time in s.

    run: drops of this run from number `first` on, or the run itself if it is over; None: keys of
    requests. The writer sets how many `rooms` (runs), `drops` and `inputs` it has deleted, and
    `next`: where the next step begins, None if there is none.
    """

    run: int | None
    before: float
    first: int = 0
    rooms: int = 0
    drops: int = 0
    inputs: int = 0
    next: int | None = None


@dataclass(slots=True, eq=False)
class Erase:
    """Take the mark and the tags of a player from some drops and inputs.

    The writer sets how many `rows` it has changed; 0: nothing of the player is left.
    """

    who: str
    rows: int = 0


@dataclass(frozen=True, slots=True)
class Mark:
    """New values for a `RoomRow` as its room advances; None keeps the old checkpoint."""

    room: int
    tick: int
    awake: bool
    used: float
    checkpoint: bytes | None = None
    checkpoint_drops: int = 0


@dataclass(frozen=True, slots=True)
class Close:
    """A room run has ended at `tick`."""

    room: int
    tick: int
    closed: float


@dataclass(frozen=True, slots=True)
class Void:
    """Pay back the stakes of all drops of a run that have no result; `why` is the reason."""

    room: int
    tick: int
    why: str


@dataclass(frozen=True, slots=True)
class FairSessionRow:
    """A player's fair session in one room, on one board: the secrets and the signed statements.

    `statement` and `end` are JSON that the server signed. `opened` is a Unix time in s.
    `client_seed` is the player's secret, once it is open.
    """

    id: str
    room: str
    board: str
    server_seed: str
    statement: str
    signature: str
    opened: float
    client_seed: str | None = None
    end: str | None = None
    end_signature: str | None = None


@dataclass(frozen=True, slots=True)
class FairOpening:
    """The player has revealed their secret. `room` is the id of the session's room."""

    session: str
    room: str
    client_seed: str


@dataclass(slots=True, eq=False)
class FairEnd:
    """A fair session ends. `room` is the id of the session's room.

    `sign` makes the end, as JSON, and its signature from the number of drops, in the writer's turn.
    """

    session: str
    room: str
    sign: Callable[[int], tuple[str, str]]
    end: str = ""
    end_signature: str = ""


LOG_LEAVES: Final = 1 << 40
"""Most leaves of a log. The leaves of log number n are stored from n * LOG_LEAVES on."""


@dataclass(slots=True, eq=False)
class LogLeaf:
    """A receipt to append to the log; the ledger sets `log`, `index`, `root` and `signature`.

    Drop `number` of the session is ball `ball` of the room run `room`. `receipt` is JSON.
    `leaf`, the log's entry, is made from it. `sign` signs it with an index, a root and the id of
    the log, None for the first log.
    """

    session: str
    number: int
    room: int
    ball: int
    receipt: dict[str, object]
    leaf: bytes
    sign: Callable[[int, str, str | None], str]
    log: int = 0
    index: int = -1
    root: str = ""
    signature: str = ""


EVERY_ROOM: Final = "*"
"""Stands for all rooms in a halt; no room has this id."""


@dataclass(frozen=True, slots=True)
class Order:
    """An action of the operator, at a Unix time in s.

    subject: a room's id, EVERY_ROOM, or a client's address or `who`. text: of an announcement.
    until: when a ban ends, Unix time in s. number: its place in the log.
    """

    action: str
    subject: str
    time: float
    text: str | None = None
    until: float | None = None
    number: int = 0


@dataclass(frozen=True, slots=True, order=True)
class Lease:
    """A server's lease of a room, valid as long as the ledger has the same `number`."""

    room: str
    number: int


@dataclass(frozen=True, slots=True)
class LeaseRow:
    """The ledger's row of a lease.

    holder: the server's name; empty if no server has the room.
    address: where other servers reach the holder; informative only.
    taken: Unix time in s.
    """

    room: str
    number: int
    holder: str
    address: str
    taken: float


@dataclass(frozen=True, slots=True)
class Received:
    """A webhook's target has received all drops of a run below `next`.

    It has received their landings, too, except those of the balls in `flying`.
    """

    target: str
    run: int
    next: int
    flying: tuple[int, ...]


Write = (
    BoardRow
    | DrawRow
    | RoomRow
    | NewDrop
    | NewInput
    | ResultRow
    | Mark
    | Void
    | Close
    | FairSessionRow
    | FairOpening
    | FairEnd
    | QueueRow
    | ShowRow
    | Order
    | Received
    | Prune
    | Erase
)
