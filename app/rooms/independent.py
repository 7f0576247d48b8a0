"""A room, pure: commands go in, events and frames come out. No I/O, no clock, no asyncio.

The state is the engine's World and what is counted beside it. Whoever holds the room sends what
comes out of it. Given the same commands at the same ticks, a room does the same again: chance and
time come in as arguments.

A drop is planned for a tick, confirmed once it is durable, and enters the world at that very tick.
A room whose next drop is neither confirmed nor refused when its tick has come is held: the tick at
which a ball starts never depends on how long the ledger took.
"""

from collections import deque
from dataclasses import dataclass
from typing import Any, Final, Literal

import msgspec
import numpy as np

from app.errors import BallLimitError
from app.protocol import messages, snapshots
from app.protocol.segments import Scale, SegmentStream
from app.rooms.stakes import payout_of
from engine import PHYSICS_VERSION, Board, World
from engine.drops.drop import start_of
from engine.errors import RecordError
from engine.seeding import parse_seed
from engine.world.events import Contact, Landing
from engine.world.world import Ball

MODE: Final = "independent"
SOLVER: Final = "exact"  # independent balls: each path depends on its own seed alone

QUIET = 0.05  # m/s; slower impacts are not told: a ball settling on a peg makes hundreds, unheard


@dataclass(frozen=True, slots=True)
class DropCommand:
    """Put a ball in: 0 <= seed < 2^64, and `x` in metres where the player chose the start.

    `stake` is in minor units, `who` a mark of the player's own.
    """

    seed: int
    x: float | None = None
    stake: int = 0
    who: str | None = None


@dataclass(slots=True, eq=False)
class Plan:
    """A drop that will be ball number `ball` and start at `tick`; `note` is the caller's own."""

    ball: int
    tick: int
    command: DropCommand
    durable: bool = False
    note: Any = None


class _Checkpoint(msgspec.Struct, frozen=True):
    """A room between two ticks."""

    world: bytes
    seq: int
    drops: int
    unsettled: int
    histogram: list[int]
    stakes: dict[int, int]


class Room:
    """One board, the balls in flight over it, and the count of what came of the others."""

    def __init__(self, room_id: str, board: Board, *, tick_rate: int, max_balls: int) -> None:
        self.id = room_id
        self.board = board
        self.tick_rate = tick_rate
        self.max_balls = max_balls
        self.world = World(board, solver=SOLVER, dt=1.0 / tick_rate)
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
        self.tick_time = 0.0  # server time of the last tick, for whoever holds the room to set
        self.seq = 0
        self.drops = 0
        self.unsettled = 0
        self.histogram = [0] * board.bins.count
        self.planned: deque[Plan] = deque()
        self._stakes: dict[int, int] = {}  # of the balls in flight, where there is one
        self._bounced: set[int] = set()
        self._segments: SegmentStream | None = None
        self._board_json = msgspec.Raw(msgspec.json.encode(board.to_dict()))

    @property
    def mode(self) -> str:
        """That each ball's path depends on its own seed alone."""
        return MODE

    @property
    def solver(self) -> Literal["exact", "stepped"]:
        """The solver that computes the paths."""
        return SOLVER

    @property
    def taken(self) -> int:
        """What the ledger counts: drops."""
        return self.drops

    @property
    def touched(self) -> bool:
        """Whether it changed between two ticks; balls begin to be seen with the next one."""
        return False

    @property
    def awake(self) -> bool:
        """Whether anything moves, or is about to."""
        return self.world.awake or bool(self.planned)

    @property
    def held(self) -> bool:
        """Whether the next tick has to wait until it is known what becomes of a planned drop."""
        return bool(self.planned) and self.planned[0].tick <= self.world.tick

    @property
    def balls(self) -> list[messages.BallStart]:
        """The balls in flight, by age."""
        return [
            messages.BallStart(ball.id, str(ball.seed), ball.x, ball.tick)
            for ball in self.world.balls
        ]

    def plan(self, command: DropCommand, lead: int = 0) -> Plan:
        """Plan a drop `lead` ticks from now, or for this very tick where nothing moves.

        Raises BallLimitError when the room is full, the engine's errors for a bad seed or start;
        the room is then as it was.
        """
        if self.world.count + len(self.planned) >= self.max_balls:
            raise BallLimitError(f"room {self.id!r} already holds {self.max_balls} balls")
        start_of(self.board, parse_seed(command.seed), command.x)
        tick = self.world.tick + lead if self.world.awake else self.world.tick
        if self.planned:
            tick = max(tick, self.planned[-1].tick)
        plan = Plan(self.drops + len(self.planned), tick, command)
        self.planned.append(plan)
        return plan

    def refuse(self, plan: Plan) -> None:
        """Take a planned drop back, as if it had never been asked for."""
        self.planned.remove(plan)

    def enter(self) -> list[tuple[Plan, list[messages.Event]]]:
        """Put in the confirmed drops whose tick it is; returns the events that say so."""
        entered: list[tuple[Plan, list[messages.Event]]] = []
        while self.planned and self.planned[0].durable and self.held:
            plan = self.planned.popleft()
            entered.append((plan, [self._add(plan)]))
        return entered

    def drop(self, command: DropCommand) -> messages.Accepted:
        """Take a drop now, at once; raises what `plan` raises."""
        plan = self.plan(command)
        plan.durable = True
        (_, (accepted,)) = self.enter()[-1]
        assert isinstance(accepted, messages.Accepted)
        return accepted

    def _add(self, plan: Plan) -> messages.Accepted:
        command = plan.command
        number = self.world.add(command.seed, x=command.x)
        if (number, self.world.tick) != (plan.ball, plan.tick):
            raise RuntimeError(f"{plan} entered as ball {number} at tick {self.world.tick}")
        ball = self.world.balls[-1]
        if command.stake:
            self._stakes[ball.id] = command.stake
        self.drops += 1
        self.seq += 1
        if self._segments is not None:
            self._follow(self._segments, ball)
        return messages.Accepted(
            ball=ball.id,
            seed=str(ball.seed),
            x=ball.x,
            explicit_x=command.x is not None,
            tick=ball.tick,
            stake=command.stake or msgspec.UNSET,
        )

    def checkpoint(self) -> bytes:
        """All that `restore` needs but the planned drops; small where nothing moves."""
        return msgspec.msgpack.encode(
            _Checkpoint(
                self.world.snapshot(),
                self.seq,
                self.drops,
                self.unsettled,
                self.histogram,
                self._stakes,
            )
        )

    def restore(self, checkpoint: bytes) -> None:
        """Become the room that made `checkpoint`; raises RecordError when it is another's."""
        try:
            saved = msgspec.msgpack.decode(checkpoint, type=_Checkpoint)
        except msgspec.MsgspecError as error:
            raise RecordError(f"the checkpoint is none: {error}", field="checkpoint") from error
        self.world.restore(saved.world)
        self.seq, self.drops, self.unsettled = saved.seq, saved.drops, saved.unsettled
        self.histogram = list(saved.histogram)
        self._stakes = dict(saved.stakes)

    def step(self, *, watched: bool) -> list[messages.Event]:
        """One tick on; returns the events to announce, in order.

        With nobody watching only landings are turned into events: contacts have no listener.
        """
        self.world.step()
        events: list[messages.Event] = []
        for happened in self.world.take_events():
            if isinstance(happened, Landing):
                events.append(self._land(happened))
            elif watched and happened.speed >= QUIET:
                events.append(self._contact(happened))
        self.seq += len(events)
        if watched:
            bodies = self.world.bodies
            self._bounced.update(bodies["id"][bodies["bounced"] != 0].tolist())
        return events

    def frame(self) -> bytes:
        """The snapshot of this moment; bounces are flagged since the frame before."""
        bodies = self.world.bodies
        if self._bounced:
            bounced = np.isin(bodies["id"], list(self._bounced))
            self._bounced.clear()
        else:
            bounced = np.zeros(len(bodies), np.bool_)
        return snapshots.encode_snapshot(
            self.world.tick, self.seq, bodies, bounced, self.extent, self.velocity_scale
        )

    def stream_of(self, wanted: str) -> str:
        """The stream a client gets that asks for `wanted`: a path has to be known to be sent."""
        return wanted if self.world.solver.name == "exact" else messages.SNAPSHOTS

    def watch_segments(self, watched: bool) -> None:
        """Cut paths into pieces from here on, while somebody watches them."""
        if not watched:
            self._segments = None
        elif self._segments is None:
            self._segments = SegmentStream(self.scale, self.world.tick)
            for ball in self.world.balls:
                self._follow(self._segments, ball)

    def segments(self) -> bytes | None:
        """The frame of the pieces that began since the last one; None if none did."""
        return None if self._segments is None else self._segments.take(self.world.tick, self.seq)

    def all_segments(self) -> bytes:
        """The frame of the piece that each ball in flight is on."""
        if self._segments is None:
            self.watch_segments(True)
        assert self._segments is not None
        return self._segments.full(self.world.tick, self.seq)

    def _follow(self, segments: SegmentStream, ball: Ball) -> None:
        segments.add(ball.id, ball.tick, self.world.trajectory(ball.id), self.world.tick)

    def stats(self) -> messages.Stats:
        """What has happened here so far."""
        return messages.Stats(self.drops, list(self.histogram), self.unsettled)

    def hello(
        self, server_time: float, limits: messages.Limits, stream: str = messages.SNAPSHOTS
    ) -> messages.Hello:
        """The full state, from which a client that comes or comes back starts."""
        return messages.Hello(
            protocol=messages.PROTOCOL_VERSION,
            physics_version=PHYSICS_VERSION,
            room=self.id,
            board_name=self.board.name,
            board_digest=self.board.digest,
            board=self._board_json,
            slots=list(self.board.slots),
            solver=SOLVER,
            mode=MODE,
            tick_rate=self.tick_rate,
            tick=self.world.tick,
            seq=self.seq,
            server_time=server_time,
            extent=self.extent,
            velocity_scale=self.velocity_scale,
            spin_scale=self.spin_scale,
            stream=stream,
            limits=limits,
            balls=self.balls,
            stats=self.stats(),
        )

    def _land(self, landing: Landing) -> messages.Landed:
        if self._segments is not None:
            self._segments.forget(landing.ball)
        self._bounced.discard(landing.ball)
        if landing.bin is None:
            self.unsettled += 1
        else:
            self.histogram[landing.bin] += 1
        stake = self._stakes.pop(landing.ball, 0)
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
        )

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
