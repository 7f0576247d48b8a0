"""The interface and the common code of both kinds of room. No I/O, no clock, no asyncio.

Inputs go in; events and binary messages come out, and the live room sends them. Chance and time
are arguments, so the same inputs at the same ticks give the same room.
"""

from abc import ABC, abstractmethod
from typing import ClassVar, Literal

import msgspec
import numpy as np
import numpy.typing as npt

from plinko.app.errors import InvalidValueError
from plinko.app.protocol import messages, snapshots
from plinko.app.rooms.draw import Draw
from plinko.app.rooms.input_format import AnyFormat
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.records import ResultRow
from plinko.app.rooms.touching.scene import Scene
from plinko.app.rooms.touching.world import Box, TouchingWorld
from plinko.engine import PHYSICS_VERSION, Board, World
from plinko.engine.json_text import JsonObject

Ground = Board | Scene
"""The board or scene in which a room's balls move."""

Basis = Ground | Draw
"""What a room is made from: a board, a scene, or a draw over a board."""

QUIET = 0.05
"""m/s; slower impacts are not sent. A ball that settles on a peg makes hundreds, all inaudible."""


class Room(ABC):
    """One board or scene, the balls in it, and counts of the drops that have ended."""

    kind: ClassVar[str]
    """The `mode` that clients receive: `independent` or `interacting`."""

    solver: ClassVar[Literal["exact", "stepped"]]
    """The solver that computes the paths."""

    format: ClassVar[AnyFormat]
    """How the ledger and the log write its inputs."""

    world: World | TouchingWorld
    extent: messages.Extent
    velocity_scale: float  # m/s of one step on the wire

    def __init__(
        self, room_id: str, origin: Ground, mode: str, *, tick_rate: int, max_balls: int
    ) -> None:
        self.id = room_id
        self.origin = origin  # the board or scene it was opened with
        self.mode = mode  # its kind's name in the ledger
        self.tick_rate = tick_rate
        self.max_balls = max_balls
        self.owned = False  # set by the live room
        self.seq = 0
        self.touched = False  # changed by an input since the last snapshot
        self._bounced: set[int] = set()
        self._begin_on(origin)

    def _begin_on(self, ground: Ground) -> None:
        """Put the room on this board or scene, with all counts at zero."""
        board = ground if isinstance(ground, Board) else None
        self.ground = ground  # a reset may have put another scene in place of `origin`
        self.drops = 0
        self.unsettled = 0
        self.histogram = [0] * (board.bins.count if board else 0)
        self._board_json = msgspec.Raw(msgspec.json.encode(board.to_dict() if board else None))

    @property
    def origin_json(self) -> bytes:
        """The board or scene that the room was opened with, as JSON."""
        if isinstance(self.origin, Board):
            return bytes(self._board_json)  # a room's board never changes
        return msgspec.json.encode(self.origin.to_dict())

    @property
    @abstractmethod
    def input_count(self) -> int:
        """Number of inputs carried out, which is the number of the next one in the ledger."""

    @property
    @abstractmethod
    def balls(self) -> list[messages.BallStart]:
        """The drops in flight, by age."""

    @property
    def awake(self) -> bool:
        """Whether anything moves, or is about to."""
        return self.world.awake

    @property
    def log_tick(self) -> int:
        """The tick at which its log ends; it stays the same while nothing moves."""
        return self.world.tick

    def log_world(self) -> str:
        """The digest of the world at that tick."""
        return self.world.digest

    @property
    def box(self) -> Box | None:
        """The walls of a scene, which has no board."""
        return None

    @property
    def draw(self) -> Draw | None:
        """The draw that decides its bins, if it has one."""
        return None

    @property
    def logged_mode(self) -> str:
        """The `mode` in its log, which says what kind of room replays the log."""
        return self.mode

    def basis_after_reset(self, board: Board | None = None) -> Basis:
        """What a reset starts from: `board`, or the original board, scene or draw.

        Raises InvalidValueError for a board that the room cannot have.
        """
        return board or self.origin

    @property
    def takes_stakes(self) -> bool:
        """Whether drops of fair sessions may have a stake here."""
        return False

    # Inputs.

    def check_drop(self, command: DropCommand, *, fair: bool) -> None:
        """Raise InvalidValueError for a drop that bypasses the room's draw.

        `fair` says that the drop belongs to a fair session.
        """
        if self.draw is None:
            return
        if not fair:
            raise InvalidValueError(
                f"room {self.id!r} has a draw: it takes drops in a fair session only, "
                "without seed, x or aim",
                field="session",
            )
        if command.aim is not None:
            raise InvalidValueError(
                f"aim {command.aim!r}: room {self.id!r} has a draw, which decides where the ball "
                "starts; leave aim out",
                field="aim",
            )

    def check_changeable(self) -> None:
        """Raise InvalidValueError if the room's balls are independent: nobody can move those."""
        raise self._unchangeable()

    def _unchangeable(self) -> InvalidValueError:
        return InvalidValueError(
            f"room {self.id!r} has independent balls, which cannot be changed; open a room "
            "with mode `interacting`, or a scene",
            field="type",
        )

    @abstractmethod
    def drop(self, command: DropCommand) -> messages.Accepted:
        """Carry out a drop at the current tick.

        Raises BallLimitError when the room is full, InvalidValueError if the room takes no drops,
        and the engine's errors for a bad start; an error leaves the room unchanged.
        """

    @abstractmethod
    def replay(self, entry: JsonObject) -> None:
        """Carry out an entry of a log at the current tick.

        Raises RecordError, InvalidValueError or the engine's errors for an entry that no room can
        have taken.
        """

    # Time.

    @abstractmethod
    def step(self, *, watched: bool) -> list[messages.Event]:
        """Advance by one tick; returns the events to announce, in order.

        Unless the room is `watched`, only landings become events; contacts interest nobody then.
        """

    @abstractmethod
    def advance(self, tick: int, *, watched: bool = False) -> list[messages.Event]:
        """Advance to this tick, as `step` does for one."""

    def take_results(self) -> list[ResultRow]:
        """The results of balls that have landed since the last call; none where balls touch."""
        return []

    @property
    def events_kept(self) -> int:
        """Number of path events in memory."""
        return 0

    def _note_bounces(self) -> None:
        bodies = self.world.bodies
        self._bounced.update(bodies["id"][bodies["bounced"] != 0].tolist())

    # Messages to clients.

    def snapshot(self, *, first: bool = False) -> bytes:
        """The balls' positions; flags each ball that bounced since the previous snapshot.

        A `first` snapshot goes to a single client and leaves those flags for the others.
        """
        bodies = self.world.bodies
        bounced = np.isin(bodies["id"], list(self._bounced))
        if not first:
            self.touched = False
            self._bounced.clear()
        return snapshots.encode_snapshot(
            self.world.tick,
            self.seq,
            bodies,
            bounced,
            self.extent,
            self.velocity_scale,
            self._asleep(bodies),
        )

    def _asleep(self, bodies: npt.NDArray[np.void]) -> npt.NDArray[np.bool_] | None:
        """Which of the balls sleep; None in a room whose balls never sleep."""
        return None

    @abstractmethod
    def stream_of(self, wanted: str) -> str:
        """The stream for a client that asks for `wanted`: only known paths can be streamed."""

    def current_path(self, ball: int) -> bytes:
        """The path of a ball in flight, for a client that has none of it."""
        raise NotImplementedError

    def due_paths(self, after: int) -> bytes:
        """The further parts of long paths that are due after tick `after`; mostly none."""
        return b""

    def first_message(self, stream: str) -> bytes | None:
        """The binary message that a client of this stream needs after the hello, if any."""
        return None

    def diagnostics(self) -> messages.Diagnostics:
        """Current energies, momenta and contacts; raises what `check_changeable` raises."""
        raise self._unchangeable()

    def stats(self) -> messages.Stats:
        return messages.Stats(self.drops, list(self.histogram), self.unsettled)

    def hello(
        self, server_time: float, limits: messages.Limits, stream: str = messages.SNAPSHOTS
    ) -> messages.Hello:
        """The full state, with which a client starts when it connects or reconnects."""
        board = self.ground if isinstance(self.ground, Board) else None
        return messages.Hello(
            protocol=messages.PROTOCOL_VERSION,
            physics_version=PHYSICS_VERSION,
            room=self.id,
            board_name=self.ground.name,
            board_digest=self.ground.digest,
            board=self._board_json,
            slots=list(board.slots) if board else [],
            solver=self.solver,
            mode=self.kind,
            tick_rate=self.tick_rate,
            tick=self.world.tick,
            seq=self.seq,
            server_time=server_time,
            extent=self.extent,
            velocity_scale=self.velocity_scale,
            stream=self.stream_of(stream),
            stakes=self.takes_stakes,
            limits=msgspec.structs.replace(limits, balls=self.max_balls),
            balls=self.balls,
            stats=self.stats(),
            arena=self._arena_state(),
            draw=self.draw.odds if self.draw is not None else msgspec.UNSET,
        )

    def _arena_state(self) -> messages.ArenaState | msgspec.UnsetType:
        """The state that only a room of touching balls has."""
        return msgspec.UNSET

    # Saving.

    def ground_fields(self) -> dict[str, object]:
        return {"board": self.origin.preset_name or self.origin.to_dict()}
