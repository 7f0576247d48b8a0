"""What a request will take, counted before it is taken. Pure.

A price is an amount of the work that a request's cost grows with: events, substeps, pixels times
frames. One over its limit is refused; what is taken is charged in s of a core, first by estimate,
then by what it took.
"""

import math
from dataclasses import dataclass
from typing import Final

from app.errors import CostError
from engine import Board
from engine.parameters import Solver, Stepped

PIXEL_FRAMES: Final = 3e8
"""Pixels times frames of an animation: some 8 s. One of 760 pixels and 30 frames/s of a preset's
drop has 1e8; the page asks for no larger ones."""

MOVING_PIXELS: Final = 4.2e6
"""Of an animation's picture: 2,048 x 2,048. Each takes 50 bytes and more while it is made, and a
worker has 256 MB."""

SUBSTEPS: Final = 1e6
"""Of one stepped drop: 88 bytes each are kept of its path."""

DROP_SUBSTEPS: Final = 3e8
"""Of many stepped drops together, whose paths are not kept: some 10 s."""

MAX_DROPS: Final = 10_000
"""Of one request; the command line takes more."""

DROP_EVENTS: Final = 1e7
"""Of many exact drops, by estimate; a board on which they have more runs into its deadline."""

BALL_SUBSTEPS: Final = 1.3e7
"""Of a box that is told again: 15 minutes of 60 balls in 4 substeps, some 9 s."""

PROOFS: Final = 512.0
"""Bins that are proven for one request."""

_EVENTS_A_DROP: Final = 60.0  # on the presets; the estimate for any board
_BOUNCES: Final = 5.0  # by which pegs make a fall longer than one past them, on the presets

# Of a core, measured: s for one of what is counted.
_EVENT: Final = 2e-6
_SUBSTEP: Final = 5e-8
_KEPT_SUBSTEP: Final = 4e-7
_BALL_SUBSTEP: Final = 7e-7
_PIXEL: Final = 6e-8
_PIXEL_FRAME: Final = 2.7e-8
_SURFACE: Final = 2e-4
_PROOF: Final = 0.04
_BYTE: Final = 6e-8  # of JSON
_ONCE: Final = 1e-3  # what any request takes that a worker does
_PRESET_DROP: Final = 2e-4  # with its record: 60 to 120 us

UNSETTLED: Final = 2.0
"""s of a core for a room in which balls fall so long that their ends are not computed at once."""

SHORT: Final = 5e-4
"""s of a core below which the server's own process computes a drop; see `ShortDrops`."""


@dataclass(frozen=True, slots=True)
class Price:
    """An amount of `what` is counted in, of `limit` at most, and the s of a core it may take."""

    what: str
    amount: float
    limit: float
    seconds: float
    field: str = ""

    def check(self) -> "Price":
        """The price; raises CostError that names it and the limit when it is over."""
        if not self.amount <= self.limit:
            raise CostError(
                f"this takes {self.amount:.3g} {self.what}, and one request may take "
                f"{self.limit:.3g}; the command line has no such limit",
                field=self.field,
            )
        return self


def fall_time(board: Board) -> float:
    """How long a ball falls that touches nothing, in s, about: no drop ends sooner."""
    height = max(board.bins.y - board.drop.y, 0.0)
    if board.gravity <= 0.0:
        return math.inf
    return max(math.sqrt(2.0 * height / board.gravity), height * board.drag / board.gravity)


def substeps_of(board: Board, solver: Stepped) -> float:
    """About how many substeps a stepped drop takes."""
    return _BOUNCES * fall_time(board) / solver.h


def one_drop(board: Board, solver: Solver) -> Price:
    """A single drop, its path kept. On a preset it is known how few events it has."""
    if isinstance(solver, Stepped):
        return stepped_drop(substeps_of(board, solver))
    seconds = _PRESET_DROP if board.preset_name else _ONCE
    return Price("events", _EVENTS_A_DROP, DROP_EVENTS, seconds)


def verification() -> Price:
    """A record that is computed again, whatever its board: as an exact drop."""
    return Price("events", _EVENTS_A_DROP, DROP_EVENTS, _ONCE)


def proofs(count: int) -> Price:
    """Bins that are proven; where one proof holds for many pixels of a map, it takes less."""
    return Price("proofs", float(count), PROOFS, _ONCE + _PROOF * count, "pixels")


def stepped_drop(substeps: float) -> Price:
    """A stepped drop of so many substeps."""
    return Price("substeps", substeps, SUBSTEPS, _ONCE + _KEPT_SUBSTEP * substeps, "dt")


def many_drops(board: Board, drops: int, solver: Solver) -> Price:
    """Drops of which only the outcomes are kept."""
    if isinstance(solver, Stepped):
        amount = drops * substeps_of(board, solver)
        return Price("drops x substeps", amount, DROP_SUBSTEPS, _ONCE + _SUBSTEP * amount, "drops")
    events = drops * _EVENTS_A_DROP
    return Price("drops x events", events, DROP_EVENTS, _ONCE + _EVENT * events, "drops")


def still(pixels: int, drops: int = 1) -> Price:
    """A picture of so many pixels, of one drop or of many."""
    seconds = _ONCE + _PIXEL * pixels + _EVENT * _EVENTS_A_DROP * drops
    return Price("pixels", float(pixels), math.inf, seconds)


def animation(pixels: int, frames: int) -> Price:
    """A picture that moves."""
    amount = float(pixels) * frames
    seconds = _ONCE + _PIXEL_FRAME * amount
    if pixels > MOVING_PIXELS:
        return Price("pixels a frame", float(pixels), MOVING_PIXELS, seconds, "width")
    return Price("pixels x frames", amount, PIXEL_FRAMES, seconds, "fps")


def check(surfaces: int) -> Price:
    """A board that is looked at whether it can be played."""
    return Price("pegs and walls", float(surfaces), math.inf, _ONCE + _SURFACE * surfaces, "board")


def json(size: int) -> Price:
    """A body of so many bytes that is read strictly."""
    return Price("bytes", float(size), math.inf, _ONCE + _BYTE * size, "body")


def story(ball_substeps: float) -> Price:
    """A box of balls that touch, told again from its beginning."""
    seconds = _ONCE + _BALL_SUBSTEP * ball_substeps
    return Price("balls x substeps", ball_substeps, BALL_SUBSTEPS, seconds, "story")
