"""Computes the flight and the path of a drop: here if it is short, on a thread if it is long."""

import asyncio
from typing import Final

from plinko.app.protocol.paths import LONG, Path, path_of
from plinko.app.rooms.records import DropRow
from plinko.engine import Board
from plinko.engine.drops.flight import Flight, SlicedFlight

_ASIDE: Final = 4096  # events of a slice on a thread
_LARGE: Final = 500  # pegs and walls of a board whose arrays take more than 1 ms to make


async def fly(board: Board, x: float) -> Flight:
    """The flight of a ball that starts at x, in m; raises EffortError if an event takes too long.

    The event loop never computes a hundred thousand impacts, nor the arrays of a large board.
    """
    flight = SlicedFlight(board, x)
    if len(board.pegs) + len(board.walls) < _LARGE and flight.advance(LONG):
        return flight.flight()
    return await asyncio.to_thread(_finish, flight)


async def cut(fact: DropRow, flight: Flight, rate: int) -> Path | None:
    """The path of a long flight; None for a short one, which the room cuts when a client needs it.

    rate: ticks a second.
    """
    if len(flight.path.events) <= LONG:
        return None
    return await asyncio.to_thread(path_of, fact.ball, fact.tick, rate, flight.path)


def _finish(flight: SlicedFlight) -> Flight:
    while not flight.advance(_ASIDE):
        pass
    return flight.flight()
