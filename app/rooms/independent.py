"""A table: a room of independent balls. Each drop is a fact, and its flight follows from that.

No ball affects another, so the state at any tick is a function of the facts: `advance` samples the
flights at the clock's tick, however late it is, and nothing has to be simulated or caught up.
"""

from collections.abc import Sequence
from typing import Final

import msgspec

from plinko.app.errors import BallLimitError, InvalidValueError
from plinko.app.protocol import messages, snapshots
from plinko.app.protocol.paths import LONG, Path, current_parts, due_parts, path_of
from plinko.app.rooms.draw import Draw
from plinko.app.rooms.drop_format import DropFormat
from plinko.app.rooms.outcome import accepted_of, landed_of, result_of
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.records import DropRow, ResultRow, TableState
from plinko.app.rooms.room import QUIET, Room
from plinko.app.rooms.stakes import check_payout
from plinko.engine import Board, World
from plinko.engine.drops.flight import Flight, fly
from plinko.engine.drops.start import aim_of, start_of
from plinko.engine.json_text import JsonObject
from plinko.engine.payouts.listing import takes_stakes
from plinko.engine.world.events import Contact, Landing

INDEPENDENT: Final = "independent"
DRAW: Final = "draw"

MOST_EVENTS: Final = 250_000
"""A table whose flights hold more path events than this takes no further drops: 14 MB, and 7
MB of paths. 200 balls on a preset have 20,000; one flight has at most 100,000."""


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
        self._flying: dict[int, tuple[DropRow, Flight]] = {}
        self._results: list[ResultRow] = []
        self._rest_tick = 0  # of the last landing
        self._paths: dict[int, Path] = {}  # of balls in flight, once a client has needed them
        self._in_parts: dict[int, Path] = {}  # those of more than one part

    @property
    def input_count(self) -> int:
        return self.drops

    @property
    def balls(self) -> list[messages.BallStart]:
        return [
            messages.BallStart(
                fact.ball,
                str(fact.seed),
                flight.x_start,
                fact.tick,
                fact.practice or msgspec.UNSET,
                **fact.tag.fields,
            )
            for fact, flight in self._flying.values()
        ]

    @property
    def awake(self) -> bool:
        return bool(self._flying)

    @property
    def log_tick(self) -> int:
        return self.world.tick if self._flying else self._rest_tick

    def log_world(self) -> str:
        if self._flying:
            return self.world.digest
        world = World(self.board, solver=self.solver, dt=1.0 / self.tick_rate)
        world.advance_to(self._rest_tick)
        world.skip_ids(self.drops)
        return world.digest

    # Drops.

    @property
    def takes_stakes(self) -> bool:
        return takes_stakes(self.board)

    def check_place(self, coming: int) -> None:
        """Raise BallLimitError if the table is full; `coming` drops are on their way."""
        if self.world.count + coming >= self.max_balls:
            raise BallLimitError(f"room {self.id!r} already has {self.max_balls} balls")
        kept = self.events_kept
        if kept > MOST_EVENTS:
            raise BallLimitError(
                f"the balls in flight in room {self.id!r} have {kept} events, more than "
                f"{MOST_EVENTS}: wait until balls have landed"
            )

    def check_start(self, command: DropCommand, *, fair: bool) -> None:
        """Raise InvalidValueError for a stake that may pay too much, or in a room for practice, and
        the engine's errors for a bad start; a fair session has yet to draw the seed."""
        check_payout(command.stake, self.board.bins.multipliers)
        if fair:
            if command.stake and not self.takes_stakes:
                raise InvalidValueError(
                    f"stake {command.stake}: room {self.id!r} is for practice, because the return "
                    "of its drops has not been counted; leave the stake out, or play on a board "
                    "whose `stakes` is true in GET boards",
                    field="stake",
                )
            if command.stake and command.aim is not None:
                raise InvalidValueError(
                    f"stake {command.stake} with aim {command.aim!r}: a drop with an aim is "
                    "practice, because payouts are solved for the board's own start; leave out "
                    "the stake or the aim",
                    field="stake",
                )
            aim_of(self.board, command.aim)
        else:
            start_of(self.board, command.seed, command.x, command.aim)

    def start_of(self, fact: DropRow) -> float:
        """Where the ball of a fact starts, m."""
        return start_of(self.board, fact.seed, fact.x, fact.aim)

    def enter(
        self,
        fact: DropRow,
        flight: Flight,
        receipt: messages.SignedReceipt | None = None,
        path: Path | None = None,
    ) -> messages.Accepted:
        """Add the ball of the next fact, whose tick is the present one or past.

        `path` is its path, if it has been cut already.
        """
        if fact.ball != self.drops or fact.tick > self.world.tick:
            raise RuntimeError(f"{fact} came as ball {self.drops} at tick {self.world.tick}")
        self.drops += 1
        self.seq += 1
        self._fly(fact, flight)
        if path is not None:
            self._keep(fact.ball, path)
        return accepted_of(self.board, fact, receipt)

    def _fly(self, fact: DropRow, flight: Flight) -> None:
        self._flying[fact.ball] = fact, flight
        self.world.add_flight(flight, fact.seed, fact.tick, fact.ball)

    def drop(self, command: DropCommand) -> messages.Accepted:
        self.check_place(0)
        self.check_start(command, fair=False)
        fact = self.fact_of(command, self.drops)
        return self.enter(fact, fly(self.board, self.start_of(fact)))

    def fact_of(self, command: DropCommand, ball: int) -> DropRow:
        """The fact of a drop at the current tick, outside of a ledger."""
        return DropRow.of(0, ball, self.world.tick, command)

    def replay(self, entry: JsonObject) -> None:
        self.drop(self.format.command(entry))

    # Time.

    @property
    def events_kept(self) -> int:
        return self.world.events_kept

    def step(self, *, watched: bool) -> list[messages.Event]:
        return self.advance(self.world.tick + 1, watched=watched)

    def advance(self, tick: int, *, watched: bool = False) -> list[messages.Event]:
        """Show the state at this tick; returns the landings since the last one, and contacts."""
        before = self.world.tick
        self.world.advance_to(tick, contacts=watched)
        events: list[messages.Event] = []
        for happened in self.world.take_events():
            if isinstance(happened, Landing):
                events.append(self._land(happened.ball))
            elif happened.speed >= QUIET:
                events.append(self._contact(happened))
        self.seq += len(events)
        if watched and self.world.tick > before:
            self._note_bounces()
        return events

    def _land(self, ball: int) -> messages.Landed:
        fact, flight = self._flying.pop(ball)
        self._paths.pop(ball, None)
        self._in_parts.pop(ball, None)
        self._bounced.discard(ball)
        result = self._count(self.result(fact, flight))
        self._results.append(result)
        return landed_of(self.board, fact, result)

    def result(self, fact: DropRow, flight: Flight) -> ResultRow:
        """How the ball of a fact lands."""
        return result_of(fact, flight, 1.0 / self.tick_rate)

    def _count(self, result: ResultRow) -> ResultRow:
        if result.bin is None:
            self.unsettled += 1
        else:
            self.histogram[result.bin] += 1
        self._rest_tick = max(self._rest_tick, result.tick)
        return result

    def take_results(self) -> list[ResultRow]:
        results, self._results = self._results, []
        return results

    def open_results(self) -> list[ResultRow]:
        """How all balls in flight will land, in the order of ticks."""
        found = [self.result(fact, flight) for fact, flight in self._flying.values()]
        return sorted(found, key=lambda result: (result.tick, result.ball))

    def land_all(self) -> list[messages.Landed]:
        """Let all balls in flight land at once, because the run is over."""
        landed = [self._land(each.ball) for each in self.open_results()]
        self.seq += len(landed)
        return landed

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

    # Loading.

    def load(
        self, state: TableState, flying: Sequence[tuple[DropRow, Flight]], tick: int
    ) -> list[ResultRow]:
        """Take over what the ledger has, at `tick`; `flying` are the drops without a result.

        Returns the results of those that have landed by then, which the ledger lacks.
        """
        self.drops = state.drops
        self.unsettled = state.sums.get(None, 0)
        for bin_ in range(len(self.histogram)):
            self.histogram[bin_] = state.sums.get(bin_, 0)
        self._rest_tick = state.rest
        landed: list[ResultRow] = []
        self.world.advance_to(tick)
        for fact, flight in flying:
            result = self.result(fact, flight)
            if result.tick <= tick:
                landed.append(self._count(result))
            else:
                self._fly(fact, flight)
                if len(flight.trajectory.impacts) > LONG:  # not later, on the event loop
                    self.path(fact.ball)
        self.world.skip_ids(state.drops)
        self.seq = state.drops + self.unsettled + sum(self.histogram)
        return landed

    # Messages to clients.

    def stream_of(self, wanted: str) -> str:
        """The stream that the client asks for: every path is known from its start on."""
        return wanted

    def path(self, ball: int) -> Path:
        path = self._paths.get(ball)
        if path is None:
            fact, flight = self._flying[ball]
            path = self._keep(ball, path_of(ball, fact.tick, self.tick_rate, flight.trajectory))
        return path

    def _keep(self, ball: int, path: Path) -> Path:
        self._paths[ball] = path
        if len(path) > 1:
            self._in_parts[ball] = path
        return path

    @property
    def uncut(self) -> list[int]:
        """The balls in flight whose paths have not been cut."""
        return [ball for ball in self._flying if ball not in self._paths]

    def cut_path(self, ball: int) -> None:
        """Cut the path of a ball now, unless it has landed."""
        if ball in self._flying:
            self.path(ball)

    def current_path(self, ball: int) -> bytes:
        return current_parts(self.path(ball), self.world.tick)

    def due_paths(self, after: int) -> bytes:
        now = self.world.tick
        return b"".join(due_parts(path, after, now) for path in self._in_parts.values())

    def first_message(self, stream: str) -> bytes | None:
        """A client of the stream `paths` starts with the paths of the balls in flight."""
        if stream != messages.PATHS or not self._flying:
            return None
        return b"".join(map(self.current_path, self._flying))


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
    def takes_stakes(self) -> bool:
        """False: the draw decides the return, which its owner chose."""
        return False

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
