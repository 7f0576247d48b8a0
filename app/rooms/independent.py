"""A room of independent balls: each path depends only on its own seed and start.

The engine's World moves the balls; the room adds stakes, tags and counts.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import msgspec

from app.errors import AppError, BallLimitError, InvalidValueError
from app.protocol import messages, snapshots
from app.protocol.segments import Scale, SegmentStream
from app.protocol.visitors import NO_TAG, Tag
from app.rooms.draw import Draw
from app.rooms.drop_format import DropFormat
from app.rooms.pending import DropCommand, Entered, PendingInput
from app.rooms.room import QUIET, Room, decode_checkpoint
from app.rooms.stakes import check_payout, payout_of
from engine import Board, World
from engine.drops.start import start_of
from engine.json_text import JsonObject
from engine.world.events import Contact, Landing

INDEPENDENT: Final = "independent"
DRAW: Final = "draw"

MOST_EVENTS: Final = 250_000
"""A room with more path events than this in memory takes no further drops: 14 MB, and some 25 MB of
segments. 200 balls on a preset have 20,000. The world keeps few events of a ball that bounces
often, so more are possible only if thousands of bounces fall into one tick."""

_FAILS: Final = 4
"""A room with this many times MOST_EVENTS fails, before it takes the memory of all rooms."""


class _Checkpoint(msgspec.Struct, frozen=True):
    """The state of a room between two ticks."""

    world: bytes
    seq: int
    drops: int
    unsettled: int
    histogram: list[int]
    stakes: dict[int, int]
    practice: list[int] = []
    tags: dict[int, Tag] = {}


class IndependentRoom(Room):
    """One board, the balls in flight over it, and counts of the drops that have ended."""

    kind = INDEPENDENT
    solver = "exact"
    format = DropFormat()

    world: World

    def __init__(
        self,
        room_id: str,
        board: Board,
        mode: str = INDEPENDENT,
        *,
        tick_rate: int,
        max_balls: int,
    ) -> None:
        super().__init__(room_id, board, mode, tick_rate=tick_rate, max_balls=max_balls)
        self.board = board
        self.world = World(board, solver=self.solver, dt=1.0 / tick_rate)
        self.extent = messages.Extent(*board.extent)
        self.velocity_scale = snapshots.velocity_scale_of(board, self.extent)
        self.spin_scale = self.velocity_scale / board.ball.radius
        self.scale = Scale(
            self.extent,
            self.velocity_scale,
            self.spin_scale,
            tick_rate,
            board.gravity,
            board.drag,
        )
        self._stakes: dict[int, int] = {}  # of balls in flight that have a stake
        self._practice: set[int] = set()  # balls in flight whose player chose seed or x
        self._tags: dict[int, Tag] = {}  # of balls in flight that have a tag
        self._segments: SegmentStream | None = None
        self._prepares = False  # another thread prepares the board

    @property
    def taken(self) -> int:
        return self.drops

    @property
    def balls(self) -> list[messages.BallStart]:
        return [
            messages.BallStart(
                ball.id,
                str(ball.seed),
                ball.x,
                ball.tick,
                self._is_practice(ball.id),
                **self._tags.get(ball.id, NO_TAG).fields,
            )
            for ball in self.world.balls
        ]

    def _is_practice(self, ball: int) -> bool | msgspec.UnsetType:
        """True or UNSET: few balls have this field."""
        return ball in self._practice or msgspec.UNSET

    @property
    def held(self) -> bool:
        """Whether the next tick must wait: for a confirmed drop to enter, or because no ball moves.

        Balls in flight need not wait for the ledger. No ball affects another, so a ball that is
        confirmed late enters late, at the place where it would be by then.
        """
        return super().held and (self.planned[0].durable or not self.world.awake)

    # Inputs.

    def plan_drop(
        self, command: DropCommand, lead: int = 0, again: str | None = None
    ) -> PendingInput[DropCommand]:
        """Plan a drop `lead` ticks from now, or for the current tick if nothing moves.

        Raises BallLimitError when the room is full or keeps too many events, InvalidValueError for
        a stake whose payout could be too large, and the engine's errors for a bad seed or start; an
        error leaves the room unchanged.
        """
        check_payout(command.stake, self.board.bins.multipliers)
        if self.world.count + len(self.planned) >= self.max_balls:
            raise BallLimitError(f"room {self.id!r} already holds {self.max_balls} balls")
        kept = self.events_kept
        if kept > MOST_EVENTS:
            raise BallLimitError(
                f"room {self.id!r} keeps {kept} events of the balls in flight and takes no drop "
                f"above {MOST_EVENTS}: wait until balls have landed"
            )
        return self._plan(self._placed(command), lead, again)

    def _placed(self, command: DropCommand) -> DropCommand:
        return replace(command, start=start_of(self.board, command.seed, command.x, command.aim))

    def replay(self, entry: JsonObject) -> None:
        command = self._placed(self.format.command(entry))
        self._carry_out(PendingInput(self.taken, self.world.tick, command))

    def _carry_out(self, pending: PendingInput[DropCommand]) -> Entered:
        command, ball = pending.command, self.world.next_id
        assert command.start is not None
        if not pending.number == self.taken == ball or pending.tick > self.world.tick:
            raise RuntimeError(f"{pending} came as ball {ball} at tick {self.world.tick}")
        if pending.tick == self.world.tick:
            self.world.add_at(command.start, command.seed)
        else:
            self.world.add_late(command.start, command.seed, pending.tick)
        if command.stake:
            self._stakes[ball] = command.stake
        if command.practice:
            self._practice.add(ball)
        if command.tag != NO_TAG:
            self._tags[ball] = command.tag
        self.drops += 1
        self.seq += 1
        if self._segments is not None and self.world.has(ball):
            self._segments.add(ball, pending.tick, self.world.tick)
        accepted = messages.Accepted(
            ball=ball,
            seed=str(command.seed),
            x=command.start,
            explicit_x=command.x is not None,
            aim=msgspec.UNSET if command.aim is None else command.aim,
            tick=pending.tick,
            stake=command.stake or msgspec.UNSET,
            practice=command.practice or msgspec.UNSET,
            receipt=pending.receipt or msgspec.UNSET,
            **command.tag.fields,
        )
        return Entered(pending, [accepted])

    # Time.

    @property
    def ready(self) -> bool:
        """Whether all paths are known up to the next tick, so that it only moves the balls."""
        return self.world.prepared and self.world.ready

    @property
    def steps_aside(self) -> bool:
        """Whether another thread should prepare the board for its first ball (large boards)."""
        return not self.world.prepared

    def begin_step(self) -> Callable[[], None] | None:
        """A function for another thread that prepares the board; None if there is no need."""
        if self._prepares or self.world.prepared:
            return None
        self._prepares = True
        return self._prepare

    def _prepare(self) -> None:
        self.world.prepare()
        self._prepares = False

    @property
    def events_kept(self) -> int:
        return self.world.events_kept

    def look_ahead(self) -> bool:
        """Compute some more events of a path; returns whether another call would help.

        Before the board is prepared, no call helps. Raises AppError if the balls bounce too often
        in one tick.
        """
        if self.events_kept > _FAILS * MOST_EVENTS:
            raise AppError(
                f"the balls in room {self.id!r} have {self.events_kept} events in one tick; a room "
                f"may keep at most {_FAILS * MOST_EVENTS}"
            )
        return self.world.prepared and self.world.look_ahead()

    def step(self, *, watched: bool) -> list[messages.Event]:
        self.world.step(contacts=watched)
        events: list[messages.Event] = []
        for happened in self.world.take_events():
            if isinstance(happened, Landing):
                events.append(self._land(happened))
            elif happened.speed >= QUIET:
                events.append(self._contact(happened))
        self.seq += len(events)
        if watched:
            self._note_bounces()
        return events

    def _land(self, landing: Landing) -> messages.Landed:
        if self._segments is not None:
            self._segments.forget(landing.ball)
        self._bounced.discard(landing.ball)
        if landing.bin is None:
            self.unsettled += 1
        else:
            self.histogram[landing.bin] += 1
        stake = self._stakes.pop(landing.ball, 0)
        practice = self._is_practice(landing.ball)
        self._practice.discard(landing.ball)
        return messages.Landed(
            ball=landing.ball,
            seed=str(landing.seed),
            bin=landing.bin,
            score=landing.score,
            tick=landing.tick,
            t=landing.t,
            x_end=landing.x_end,
            digest=landing.digest,
            unsettled=landing.unsettled,
            payout=payout_of(stake, landing.score) if stake else msgspec.UNSET,
            practice=practice,
            label=self.board.bins.label_of(landing.bin) or msgspec.UNSET,
            **self._tags.pop(landing.ball, NO_TAG).fields,
        )

    def give_up(self, why: str) -> list[messages.Landed]:
        tick = self.world.tick
        return [
            messages.Landed(
                ball=ball.id,
                seed=str(ball.seed),
                bin=None,
                score=1.0,
                tick=tick,
                t=0.0,
                x_end=0.0,
                digest=None,
                unsettled=why,
                payout=self._stakes.get(ball.id, 0) or msgspec.UNSET,
                **self._tags.get(ball.id, NO_TAG).fields,
            )
            for ball in self.world.balls
        ]

    def _contact(self, contact: Contact) -> messages.Contact:
        return messages.Contact(
            ball=contact.ball,
            tick=self.world.tick,
            t=contact.t,
            x=contact.x,
            y=contact.y,
            kind=contact.kind,
            index=contact.index,
            speed=contact.speed,
        )

    # Messages to clients.

    def stream_of(self, wanted: str) -> str:
        """The stream that the client asks for: every path is known from its start on."""
        return wanted

    def watch_segments(self, watched: bool) -> None:
        if not watched:
            self._segments = None
        elif self._segments is None:
            self._segments = SegmentStream(self.scale, self.world.tick)
            for ball in self.world.balls:
                self._segments.add(ball.id, ball.tick, self.world.tick)

    def segments(self) -> bytes | None:
        if self._segments is None:
            return None
        self._extend(self._segments)
        return self._segments.take(self.world.tick, self.seq)

    def keyframe(self) -> bytes:
        """A message with the current segment of each ball in flight."""
        self.watch_segments(True)
        assert self._segments is not None
        self._extend(self._segments)
        return self._segments.full(self.world.tick, self.seq)

    def first_message(self, stream: str) -> bytes | None:
        """A client of the segment stream starts from the current segments."""
        return self.keyframe() if stream == messages.SEGMENTS else None

    def _extend(self, segments: SegmentStream) -> None:
        """Cut the newly computed parts of the paths into segments."""
        for ball, known in zip(self.world.balls, self.world.known, strict=True):
            if segments.needs(ball.id, known):
                segments.extend(ball.id, *self.world.ahead(ball.id))

    # Saving.

    def checkpoint(self) -> bytes:
        return msgspec.msgpack.encode(
            _Checkpoint(
                self.world.snapshot(),
                self.seq,
                self.drops,
                self.unsettled,
                self.histogram,
                self._stakes,
                sorted(self._practice),
                self._tags,
            )
        )

    def restore(self, checkpoint: bytes) -> None:
        saved = decode_checkpoint(checkpoint, _Checkpoint)
        self.world.restore(saved.world)
        self.seq, self.drops, self.unsettled = saved.seq, saved.drops, saved.unsettled
        self.histogram = list(saved.histogram)
        self._stakes = dict(saved.stakes)
        self._practice = set(saved.practice)
        self._tags = dict(saved.tags)


class DrawRoom(IndependentRoom):
    """A room with a draw: a fair session picks a bin by exact odds, then one of its seeds.

    The drop of that seed is an ordinary drop of independent balls.
    """

    def __init__(self, room_id: str, draw: Draw, *, tick_rate: int, max_balls: int) -> None:
        super().__init__(room_id, draw.board, DRAW, tick_rate=tick_rate, max_balls=max_balls)
        self._draw = draw

    @property
    def draw(self) -> Draw:
        return self._draw

    @property
    def logged_mode(self) -> str:
        """The mode without a draw: a replay needs only the seeds, which are in the log."""
        return INDEPENDENT

    def basis_after_reset(self, board: Board | None = None) -> Draw:
        """The same draw; raises InvalidValueError for another board, whose bins it cannot fit."""
        if board is not None:
            raise InvalidValueError(
                f"room {self.id!r} has a draw, whose seeds fit only its board; open another room "
                "for another board",
                field="board",
            )
        return self._draw
