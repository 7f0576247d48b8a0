"""Computes the flight of a drop: here if it is short, on a thread if it is long."""

import asyncio
from typing import Final

from engine import Board
from engine.drops.flight import Flight, SlicedFlight

_HERE: Final = 256  # events computed on the event loop: 0.2 ms; most drops on presets have fewer
_ASIDE: Final = 4096  # events of a slice on a thread
_LARGE: Final = 500  # pegs and walls of a board whose arrays take more than 1 ms to make


async def fly(board: Board, x: float) -> Flight:
    """The flight of a ball that starts at x, in m; raises EffortError if an event takes too long.

    The event loop never computes a hundred thousand impacts, nor the arrays of a large board.
    """
    flight = SlicedFlight(board, x)
    if len(board.pegs) + len(board.walls) < _LARGE and flight.advance(_HERE):
        return flight.flight()
    return await asyncio.to_thread(_finish, flight)


def _finish(flight: SlicedFlight) -> Flight:
    while not flight.advance(_ASIDE):
        pass
    return flight.flight()
