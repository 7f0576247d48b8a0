"""What every room is, whether its balls touch each other or not. No I/O, no clock, no asyncio.

Commands go in, events and binary messages come out; whoever holds the room sends them. Given the
same commands at the same ticks, a room does the same again: chance and time come in as arguments.

An input is planned for a tick, confirmed once it is durable, and carried out at that very tick. A
room whose next input is neither confirmed nor refused when its tick has come is held: the tick at
which a ball starts never depends on how long the ledger took.
"""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from typing import ClassVar, Literal, Protocol, TypeVar

import msgspec
import numpy as np
import numpy.typing as npt

from app.errors import InvalidValueError
from app.protocol import messages, snapshots
from app.protocol.touching_messages import Change
from app.rooms.draw import Draw
from app.rooms.input_format import AnyFormat
from app.rooms.pending import Command, DropCommand, Entered, Pending, PendingInput
from app.rooms.touching.scene import Scene
from app.rooms.touching.world import Box
from engine import PHYSICS_VERSION, Board
from engine.errors import RecordError
from engine.json_text import JsonObject

Ground = Board | Scene
"""What stands in a room."""

Basis = Ground | Draw
"""What a room is made of: what stands in it, or a draw over a board."""

QUIET = 0.05  # m/s; slower impacts are not told: a ball settling on a peg makes hundreds, unheard

Saved = TypeVar("Saved")


class RoomWorld(Protocol):
    """What moves in a room, as far as every room has it."""

    tick: int

    @property
    def awake(self) -> bool:
        """Whether anything moves."""

    @property
    def count(self) -> int:
        """Number of balls."""

    @property
    def bodies(self) -> npt.NDArray[np.void]:
        """The balls, by id."""

    def digest(self) -> str:
        """SHA-256 of the world, 64 hex digits: equal worlds have equal digests."""


class Room(ABC):
    """One board or scene, the balls in it, and the count of what came of the others."""

    kind: ClassVar[str]
    """How its balls fall, as clients are told: `independent` or `interacting`."""

    solver: ClassVar[Literal["exact", "stepped"]]
    """The solver that computes the paths."""

    format: ClassVar[AnyFormat]
    """How its inputs are kept and logged."""

    world: RoomWorld
    extent: messages.Extent
    velocity_scale: float  # m/s of one step on the wire
    spin_scale: float  # rad/s of one step on the wire

    def __init__(
        self, room_id: str, origin: Ground, mode: str, *, tick_rate: int, max_balls: int
    ) -> None:
        self.id = room_id
        self.origin = origin  # what it was opened over
        self.mode = mode  # as the ledger calls its kind
        self.tick_rate = tick_rate
        self.max_balls = max_balls
        self.owned = False  # for whoever holds the room to set
        self.seq = 0
        self.touched = False  # changed since the last snapshot, and not by a tick
        self.planned: deque[Pending] = deque()
        self._bounced: set[int] = set()
        self._begin_on(origin)

    def _begin_on(self, ground: Ground) -> None:
        """Count from zero what comes of drops on this ground."""
        board = ground if isinstance(ground, Board) else None
        self.ground = ground  # what stands there now
        self.drops = 0
        self.unsettled = 0
        self.histogram = [0] * (board.bins.count if board else 0)
        self._board_json = msgspec.Raw(msgspec.json.encode(board.to_dict() if board else None))

    @property
    @abstractmethod
    def taken(self) -> int:
        """Inputs carried out so far, as the ledger counts them."""

    @property
    @abstractmethod
    def balls(self) -> list[messages.BallStart]:
        """The drops in flight, by age."""

    @property
    def awake(self) -> bool:
        """Whether anything moves, or is about to."""
        return bool(self.planned) or self.world.awake

    @property
    def is_scene(self) -> bool:
        """Whether it is there to be looked at alone: no drop in it is waited for."""
        return False

    @property
    def late(self) -> bool:
        """Whether the tick of a planned input has passed without it."""
        return bool(self.planned) and self.planned[0].tick < self.world.tick

    @property
    def held(self) -> bool:
        """Whether the next tick has to wait until it is known what becomes of a planned input."""
        return bool(self.planned) and self.planned[0].tick <= self.world.tick

    @property
    def box(self) -> Box | None:
        """What stands where there is no board."""
        return None

    @property
    def draw(self) -> Draw | None:
        """The draw by which its bins are drawn, if it has one."""
        return None

    @property
    def logged_mode(self) -> str:
        """How its log calls its kind: which room replays the log."""
        return self.mode

    def basis_after_reset(self, board: Board | None = None) -> Basis:
        """What the room restarts with; raises InvalidValueError for a board that it cannot have."""
        return board or self.origin

    # Inputs.

    def check_drop(self, command: DropCommand, *, fair: bool) -> None:
        """Raise InvalidValueError for a drop that a draw does not decide; `fair`: of a session."""
        if self.draw is None:
            return
        if not fair:
            raise InvalidValueError(
                f"room {self.id!r} has a draw: a ball is dropped there in a fair session only, "
                "without seed, x or aim",
                field="session",
            )
        if command.aim is not None:
            raise InvalidValueError(
                f"aim {command.aim!r}: room {self.id!r} has a draw, where nobody aims", field="aim"
            )

    @abstractmethod
    def plan_drop(self, command: DropCommand, lead: int = 0, again: str | None = None) -> Pending:
        """Plan a drop `lead` ticks from now, or for this very tick where nothing moves.

        Raises BallLimitError when the room is full, InvalidValueError where nothing can be
        dropped, the engine's errors for a bad start; the room is then as it was.
        """

    def plan_change(self, change: Change, lead: int = 0) -> Pending:
        """Plan a change as `plan_drop` plans a drop; raises InvalidValueError where none can be."""
        raise self._unchangeable()

    def check_changeable(self) -> None:
        """Raise InvalidValueError unless the balls touch each other, so that they can be moved."""
        raise self._unchangeable()

    def _unchangeable(self) -> InvalidValueError:
        return InvalidValueError(
            f"room {self.id!r} is one of independent balls, which cannot be changed; open one "
            "with mode `interacting`, or a scene",
            field="type",
        )

    def _plan(self, command: Command, lead: int, again: str | None = None) -> PendingInput[Command]:
        tick = self.world.tick + lead if self._runs else self.world.tick
        if self.planned:
            tick = max(tick, self.planned[-1].tick)
        number = self.taken + len(self.planned)
        pending = PendingInput(number, tick, command, again=again)
        self.planned.append(pending)
        return pending

    @property
    def _runs(self) -> bool:
        return self.world.awake

    def refuse(self, pending: Pending) -> None:
        """Take back the input that was planned last, as if it had never been asked for.

        Raises RuntimeError for any other: those after it have numbers that follow on from its own.
        """
        if not self.planned or self.planned[-1] is not pending:
            raise RuntimeError(f"{pending} was refused, but not those that were planned after it")
        self.planned.pop()

    def enter(self) -> list[Entered]:
        """Carry out the confirmed inputs whose tick it is; returns what to tell of each."""
        entered: list[Entered] = []
        while self.planned and self.planned[0].durable and self.held:
            # One that cannot be carried out stays planned: whoever asked for it is to hear.
            entered.append(self._carry_out(self.planned[0]))
            self.planned.popleft()
        return entered

    def drop(self, command: DropCommand) -> messages.Accepted:
        """Take a drop now, at once; raises what `plan_drop` raises."""
        self.plan_drop(command).durable = True
        (accepted,) = self.enter()[-1].events
        assert isinstance(accepted, messages.Accepted)
        return accepted

    @abstractmethod
    def replay(self, entry: JsonObject) -> None:
        """Take an input that a room has taken before, an entry of its log; its tick is now.

        Raises RecordError, InvalidValueError and the engine's errors for what was never taken.
        """

    @abstractmethod
    def _carry_out(self, pending: Pending) -> Entered:
        """Do what was planned."""

    def _check_turn(self, pending: Pending) -> None:
        if (pending.number, pending.tick) != (self.taken, self.world.tick):
            raise RuntimeError(f"{pending} came as input {self.taken} at tick {self.world.tick}")

    # Time.

    @property
    def ready(self) -> bool:
        """Whether the next tick takes no more than it always does."""
        return True

    def look_ahead(self) -> bool:
        """Do a little of what later ticks need; whether there is more that would help.

        It changes nothing of what happens, only when it is computed: `step` does what is left.
        """
        return False

    @property
    def steps_aside(self) -> bool:
        """Whether a tick takes so long that another thread is to compute it."""
        return False

    def begin_step(self) -> Callable[[], None] | None:
        """What another thread is to compute of the next tick; None where there is nothing.

        It touches nothing that anyone else does. Once it has run, the room is ready, unless an
        input was carried out meanwhile: then there is another to begin.
        """
        return None

    @abstractmethod
    def step(self, *, watched: bool) -> list[messages.Event]:
        """One tick on; returns the events to announce, in order.

        With nobody watching only landings are turned into events: contacts have no listener.
        """

    @property
    def events_kept(self) -> int:
        """Events of paths that are held in memory."""
        return 0

    def give_up(self, why: str) -> list[messages.Landed]:
        """What to tell of drops in flight that will never land: no bin, and their stake back.

        Of a room that has failed: nothing is asked of what moves in it.
        """
        return []

    def _note_bounces(self) -> None:
        bodies = self.world.bodies
        self._bounced.update(bodies["id"][bodies["bounced"] != 0].tolist())

    # What is told.

    def snapshot(self, *, first: bool = False) -> bytes:
        """Where the balls are at this moment; bounces are flagged since the snapshot before.

        The `first` one that a client gets is no news to the others.
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
        """Which of the balls sleep; None where none ever does."""
        return None

    @abstractmethod
    def stream_of(self, wanted: str) -> str:
        """The stream a client gets that asks for `wanted`: a path has to be known to be sent."""

    @abstractmethod
    def watch_segments(self, watched: bool) -> None:
        """Cut paths into pieces from here on, while somebody watches them."""

    def segments(self) -> bytes | None:
        """The pieces that began since the last call, as a message; None if none did."""
        return None

    def keyframe(self) -> bytes:
        """The message from which a client goes on that has not got all before."""
        return self.snapshot(first=True)

    def first_message(self, stream: str) -> bytes | None:
        """The binary message that a client of this stream needs beside the hello, if any."""
        return None

    def diagnostics(self) -> messages.Diagnostics:
        """Energies, momenta, contacts of this moment; raises what `check_changeable` raises."""
        raise self._unchangeable()

    def stats(self) -> messages.Stats:
        return messages.Stats(self.drops, list(self.histogram), self.unsettled)

    def hello(
        self, server_time: float, limits: messages.Limits, stream: str = messages.SNAPSHOTS
    ) -> messages.Hello:
        """The full state, from which a client that comes or comes back starts."""
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
            spin_scale=self.spin_scale,
            stream=self.stream_of(stream),
            limits=msgspec.structs.replace(limits, balls=self.max_balls),
            balls=self.balls,
            stats=self.stats(),
            arena=self._arena_state(),
            draw=self.draw.odds if self.draw is not None else msgspec.UNSET,
        )

    def _arena_state(self) -> messages.ArenaState | msgspec.UnsetType:
        """What only a room has whose balls touch each other."""
        return msgspec.UNSET

    # Saving.

    @abstractmethod
    def checkpoint(self) -> bytes:
        """All that `restore` needs but the planned inputs; small where nothing moves."""

    @abstractmethod
    def restore(self, checkpoint: bytes) -> None:
        """Become the room that made `checkpoint`; raises RecordError when it is another's."""

    @property
    def origin_json(self) -> bytes:
        """What it was opened over; a board is made JSON once, where the room is made."""
        if isinstance(self.origin, Board):
            return bytes(self._board_json)  # which stands there as long as the room lives
        return msgspec.json.encode(self.origin.to_dict())

    def ground_fields(self) -> dict[str, object]:
        return {"board": self.origin.preset_name or self.origin.to_dict()}


def decode_checkpoint(checkpoint: bytes, kind: type[Saved]) -> Saved:
    """The values of a checkpoint; raises RecordError when it is none of this kind."""
    try:
        return msgspec.msgpack.decode(checkpoint, type=kind)
    except msgspec.MsgspecError as error:
        raise RecordError(f"the checkpoint is none: {error}", field="checkpoint") from error
