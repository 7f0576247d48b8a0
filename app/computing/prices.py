"""Estimate what a request will cost before it is computed, and refuse it if that is too much. Pure.

A price counts the unit of work that dominates a request, such as events, substeps, or pixels times
frames. A request over the limit is refused. Otherwise the client's budget is charged the estimate
in CPU seconds, and corrected by the measured time afterwards.
"""

import math
from typing import Final, NamedTuple

from plinko.app.errors import CostError
from plinko.engine import Board
from plinko.engine.parameters import Solver, Stepped

PIXEL_FRAMES: Final = 3e8
"""Pixels times frames of an animation: about 8 s. A preset's drop, 760 pixels wide at 30 frames/s,
has 1e8; the page requests no larger ones."""

MOVING_PIXELS: Final = 4.2e6
"""Pixels of an animation's frame: 2,048 x 2,048. A pixel takes 50 bytes or more during drawing,
and a worker has 256 MB."""

SUBSTEPS: Final = 1e6
"""Substeps of one stepped drop. Its path takes 88 bytes per substep."""

DROP_SUBSTEPS: Final = 3e8
"""Substeps of many stepped drops together, without their paths: about 10 s."""

MAX_DROPS: Final = 10_000
"""Drops of one request; the command line takes more."""

DROP_EVENTS: Final = 1e7
"""Estimated events of many exact drops. On a board with longer drops, the deadline ends them."""

BALL_SUBSTEPS: Final = 1.3e7
"""Balls times substeps of a replayed box: 15 minutes of 60 balls in 4 substeps, about 9 s."""

_EVENTS_A_DROP: Final = 60.0  # on the presets; the estimate for any board
_BOUNCES: Final = 5.0  # how much longer a fall takes with pegs than without, on the presets

# Measured CPU seconds for one unit of each kind.
_EVENT: Final = 2e-6
_SUBSTEP: Final = 5e-8
_KEPT_SUBSTEP: Final = 4e-7
_BALL_SUBSTEP: Final = 7e-7
_PIXEL: Final = 6e-8
_PIXEL_FRAME: Final = 2.7e-8
_SURFACE: Final = 2e-4
_PROOF: Final = 0.04
_BYTE: Final = 6e-8  # of JSON
_ONCE: Final = 1e-3  # fixed cost of any job for a worker
_PRESET_RECORD: Final = 2e-4  # 60 to 120 us


class Price(NamedTuple):
    """An amount of work in the unit `what`, its limit, and its estimate in CPU seconds.

    Workers take `quick` jobs before others. preset: the server's own process computes a job whose
    only work is a drop on this board; see `Computing.at_once`.
    """

    what: str
    amount: float
    limit: float
    seconds: float
    field: str = ""
    quick: bool = False
    preset: Board | None = None

    def check(self) -> "Price":
        """Return the price; raises CostError if it is over the limit."""
        if not self.amount <= self.limit:
            raise CostError(
                f"this takes {self.amount:.3g} {self.what}, and one request may take "
                f"{self.limit:.3g}; the command line has no such limit",
                field=self.field,
            )
        return self


def fall_time(board: Board) -> float:
    """Rough time in s of a fall that touches no peg: no drop ends sooner."""
    height = max(board.bins.y - board.drop.y, 0.0)
    if board.gravity <= 0.0:
        return math.inf
    return max(math.sqrt(2.0 * height / board.gravity), height * board.drag / board.gravity)


def substeps_of(board: Board, solver: Stepped) -> float:
    return _BOUNCES * fall_time(board) / solver.h


def one_drop(board: Board, solver: Solver) -> Price:
    """One drop with its path."""
    if isinstance(solver, Stepped):
        return stepped_drop(substeps_of(board, solver))
    return Price("events", _EVENTS_A_DROP, DROP_EVENTS, _ONCE, quick=True)


def record(board: Board, solver: Solver) -> Price:
    """One drop's record. On a preset, drops are known to have few events."""
    if isinstance(solver, Stepped) or not board.preset_name:
        return one_drop(board, solver)
    return Price("events", _EVENTS_A_DROP, DROP_EVENTS, _PRESET_RECORD, preset=board)


def verification() -> Price:
    """Recompute a drop's record: costs as much as an exact drop."""
    return Price("events", _EVENTS_A_DROP, DROP_EVENTS, _ONCE)


def proof() -> Price:
    return Price("proofs", 1.0, 1.0, _ONCE + _PROOF)


def stepped_drop(substeps: float) -> Price:
    seconds = _ONCE + _KEPT_SUBSTEP * substeps
    return Price("substeps", substeps, SUBSTEPS, seconds, "dt", quick=True)


def many_drops(board: Board, drops: int, solver: Solver) -> Price:
    """Many drops without their paths."""
    if isinstance(solver, Stepped):
        amount = drops * substeps_of(board, solver)
        return Price("drops x substeps", amount, DROP_SUBSTEPS, _ONCE + _SUBSTEP * amount, "drops")
    events = drops * _EVENTS_A_DROP
    return Price("drops x events", events, DROP_EVENTS, _ONCE + _EVENT * events, "drops")


def still(pixels: int, drops: int = 1) -> Price:
    """A picture of one drop or of many."""
    seconds = _ONCE + _PIXEL * pixels + _EVENT * _EVENTS_A_DROP * drops
    return Price("pixels", float(pixels), math.inf, seconds)


def animation(pixels: int, frames: int) -> Price:
    amount = float(pixels) * frames
    seconds = _ONCE + _PIXEL_FRAME * amount
    if pixels > MOVING_PIXELS:
        return Price("pixels a frame", float(pixels), MOVING_PIXELS, seconds, "width")
    return Price("pixels x frames", amount, PIXEL_FRAMES, seconds, "fps")


def check(surfaces: int) -> Price:
    """Check whether a board of `surfaces` pegs and walls can be played."""
    seconds = _ONCE + _SURFACE * surfaces
    return Price("pegs and walls", float(surfaces), math.inf, seconds, "board", quick=True)


def json(size: int) -> Price:
    return Price("bytes", float(size), math.inf, _ONCE + _BYTE * size, "body", quick=True)


def story(ball_substeps: float) -> Price:
    """Replay a box of touching balls from its beginning."""
    seconds = _ONCE + _BALL_SUBSTEP * ball_substeps
    return Price("balls x substeps", ball_substeps, BALL_SUBSTEPS, seconds, "story")
