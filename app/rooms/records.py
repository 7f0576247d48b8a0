"""What the ledger keeps, as frozen values: a board, a run of a room, a drop, a result."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from app.protocol.visitors import NO_TAG, Tag


@dataclass(frozen=True, slots=True)
class BoardRow:
    """A board by its content."""

    digest: str
    name: str
    json: str


@dataclass(frozen=True, slots=True)
class DrawRow:
    """A room's draw by its content."""

    digest: str
    json: str


@dataclass(frozen=True, slots=True)
class KeptBasis:
    """What a room run is made of, as the ledger has it: None for what it lacks, or has no need of.

    board: JSON, of a scene too; draw: JSON, of a run that has one.
    """

    board: str | None
    draw: str | None


@dataclass(frozen=True, slots=True)
class RoomRow:
    """A run of the room `id`: one world from tick 0 on; `number` is its own, for ever.

    `tick` is one that nobody was shown a later one than. `checkpoint` is a world to start a replay
    from, after `checkpoint_drops` drops (or inputs); None means the world at tick 0. Times are
    Unix times. `creator` is a mark of who made it, where rooms are counted by that; `key` is that
    of the request that began it. `draw`: the digest of its draw, if it has one.
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
    key: str | None = None
    draw: str | None = None


@dataclass(frozen=True, slots=True)
class Parked:
    """A sleeping room that is not in memory: what a list shows of it."""

    number: int
    id: str
    board_name: str
    board: str
    mode: str
    tick: int
    drops: int
    used: float

    @classmethod
    def of(cls, row: RoomRow, board_name: str) -> "Parked":
        drops = row.checkpoint_drops
        return cls(row.number, row.id, board_name, row.board, row.mode, row.tick, drops, row.used)


@dataclass(frozen=True, slots=True)
class Listed:
    """An open room of a ledger that servers share, and whether something moved in it last."""

    room: Parked
    awake: bool


@dataclass(frozen=True, slots=True)
class DropRow:
    """An accepted drop: ball number `ball` of its room starts at `tick`; `stake` in minor units.

    `x` and `aim` in m, where the player chose one. `key`: by which it may be asked for again.
    `name` and `colour`: its tag.
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
    key: str | None = None
    name: str | None = None
    colour: str | None = None

    @property
    def tag(self) -> Tag:
        return Tag(self.name, self.colour) if self.name or self.colour else NO_TAG

    @property
    def number(self) -> int:
        return self.ball


@dataclass(frozen=True, slots=True)
class OpenDrop:
    """A drop that has no result yet: all that is needed to give its `stake` back."""

    room: int
    ball: int
    stake: int


@dataclass(frozen=True, slots=True)
class InputRow:
    """Input `number` of a room whose balls touch each other, as JSON, carried out at `tick`."""

    room: int
    number: int
    tick: int
    data: str
    who: str | None = None
    key: str | None = None


@dataclass(frozen=True, slots=True)
class ResultRow:
    """How a drop ended, with the digest of all it went through; `payout` in minor units."""

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
"""What the ledger keeps of an input: a drop, or what was done where balls touch each other."""


@dataclass(frozen=True, slots=True)
class QueueRow:
    """What waits to be dropped in the run `room`, as JSON, in place of what did."""

    room: int
    data: str


@dataclass(frozen=True, slots=True)
class Pruned:
    """How much was deleted: runs of rooms, their drops and inputs."""

    rooms: int
    drops: int
    inputs: int


@dataclass(frozen=True, slots=True)
class Mark:
    """How far a room has come: what `RoomRow` says, brought up to date. None leaves as is."""

    room: int
    tick: int
    awake: bool
    used: float
    checkpoint: bytes | None = None
    checkpoint_drops: int = 0


@dataclass(frozen=True, slots=True)
class Close:
    """A run is over, at `tick`."""

    room: int
    tick: int
    closed: float


@dataclass(frozen=True, slots=True)
class Void:
    """Every drop of a run without a result gets its stake back, at `tick`, and that is why."""

    room: int
    tick: int
    why: str


@dataclass(frozen=True, slots=True)
class FairSessionRow:
    """A player's session: both secrets, and what the server signed of it, as JSON.

    Its drops are those of one room, on one board. `used` is in Unix time, when it began.
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
    """The player opened their secret. `room` is the id of the session's room."""

    session: str
    room: str
    client_seed: str


@dataclass(frozen=True, slots=True)
class FairEnd:
    """A session is over. `room` is the id of the session's room."""

    session: str
    room: str
    end: str
    end_signature: str


@dataclass(slots=True, eq=False)
class LogLeaf:
    """A receipt on its way into the log, where it gets its place: `index`, `root`, `signature`.

    Drop `number` of a session is ball `ball` of the room run `room`. `leaf` are its bytes in
    the log, `sign` signs them with their place; both follow from `receipt`, which is JSON.
    """

    session: str
    number: int
    room: int
    ball: int
    receipt: dict[str, object]
    leaf: bytes
    sign: Callable[[int, str], str]
    index: int | None = None
    root: str = ""
    signature: str = ""


@dataclass(frozen=True, slots=True)
class ReceiptRow:
    """A receipt in the log; `receipt` is JSON."""

    leaf: int
    session: str
    number: int
    room: int
    ball: int
    receipt: str
    root: str
    signature: str


EVERY_ROOM: Final = "*"
"""Stands for all rooms where one is halted; no room has this id."""


@dataclass(frozen=True, slots=True)
class Halt:
    """A room, or EVERY_ROOM, takes nothing new `since` this Unix time, in s."""

    room: str
    since: float


@dataclass(frozen=True, slots=True)
class Release:
    """A room, or EVERY_ROOM, is halted no more."""

    room: str


@dataclass(frozen=True, slots=True, order=True)
class Lease:
    """That a server has the room `room`, for as long as the ledger has the same `number` of it."""

    room: str
    number: int


@dataclass(frozen=True, slots=True)
class LeaseRow:
    """Who has a room: `holder` by name, \"\" for nobody, since `taken` in Unix time, in s.

    `address` is where the other servers reach it: for people who read the table.
    """

    room: str
    number: int
    holder: str
    address: str
    taken: float


@dataclass(frozen=True, slots=True)
class Heard:
    """A webhook's target has heard of the events of these numbers."""

    numbers: tuple[int, ...]


Write = (
    BoardRow
    | DrawRow
    | RoomRow
    | DropRow
    | InputRow
    | ResultRow
    | Mark
    | Void
    | Close
    | FairSessionRow
    | FairOpening
    | FairEnd
    | LogLeaf
    | QueueRow
    | Halt
    | Release
    | Heard
)
