"""Rooms that a test ticks by hand, in whole passes of the ticker without waiting."""

from typing import Any

from plinko.app.live.broadcast.hub import Hub
from plinko.app.live.live_room import LiveRoom
from plinko.app.live.public_tables import MAIN
from plinko.app.live.registry import Rooms
from plinko.app.live.ticking.runner import Runner
from plinko.app.persistence.service import PersistenceService
from plinko.app.rooms.boards import Boards
from plinko.app.rooms.kinds import MAX_TOUCHING, BallLimits, make_room
from plinko.app.settings import TICK_RATE, Settings
from plinko.engine import Board
from tests.kit.hand import HandClock
from tests.kit.null_ledger import NullLedger


def run_pass(runner: Runner, due: int = 1) -> bool:
    """Tick every awake room `due` times; returns whether a room is still awake.

    If the runner goes by a clock that the test moves, it moves by as many ticks.
    """
    if isinstance(runner.clock, HandClock):
        runner.clock.tick(due)
    *_, awake = runner.tick(due)
    return awake


class RoomsByHand(Rooms):
    """Opens public rooms without asking the ledger."""

    def find(self, room_id: str) -> LiveRoom:
        if not self.is_open(room_id) and room_id in self.public:
            runs = self.persistence.runs
            number, runs.next_number = runs.next_number, runs.next_number + 1
            runs.begin(room_id, runs.made(number))
            basis, mode = self.public.find(room_id)
            limits = self.persistence.limits
            room = make_room(room_id, basis, mode, tick_rate=TICK_RATE, limits=limits)
            return self._open.add(room)
        return super().find(room_id)


def rooms_by_hand(
    main: Board,
    clock: HandClock | None = None,
    *,
    ledger: NullLedger | None = None,
    settings: Settings | None = None,
    clients: int = 64,
    **options: Any,
) -> Rooms:
    """Rooms whose ticks and times go by a clock that `run_pass` moves."""
    clock, chosen = clock or HandClock(), settings or Settings()
    kept = PersistenceService(
        ledger or NullLedger(),
        limits=BallLimits(chosen.max_balls, MAX_TOUCHING),
        now=clock.unix,
    )
    hub = Hub(clients)
    rooms = RoomsByHand(chosen, Boards(8), hub, main, kept, clock=clock, **options)
    rooms.find(MAIN)
    return rooms
