"""Facts about every preset for lists, and which of them take stakes, without laying out boards."""

from dataclasses import dataclass
from functools import cache
from typing import Final

from plinko.engine.board import presets
from plinko.engine.board.model import Board
from plinko.engine.board.payouts import TABLES, Risk
from plinko.engine.board.presets import HOUSE, TRIANGLE_HEIGHT, TRIANGLE_WIDTH, VARIANTS
from plinko.engine.board.worlds import WORLDS
from plinko.engine.payouts.record import shipped

LEAST_RETURN: Final = 0.985
MOST_RETURN: Final = 0.995
"""A preset takes stakes if the drops that judge its table return a share within these bounds."""


@dataclass(frozen=True, slots=True)
class Listed:
    """A board's row in a list.

    world: None for a board that is not a preset. rows, risk: None unless it is a preset triangle.
    size: width and height in m. returned: from the board's own start; None if it was never counted.
    """

    name: str
    digest: str
    world: str | None
    rows: int | None
    risk: Risk | None
    bins: int
    pegs: int
    size: tuple[float, float]
    multipliers: tuple[float, ...]
    returned: float | None

    @property
    def stakes(self) -> bool:
        """Whether the board takes stakes."""
        return self.returned is not None and LEAST_RETURN <= self.returned <= MOST_RETURN


@cache
def listed(name: str) -> Listed:
    variant = VARIANTS.get(name)
    if variant is None:
        board = Board.preset(name)
        return row_of(board, HOUSE, _returned(name))
    world, rows, risk = variant
    size = WORLDS[world].size if world in WORLDS else 1.0
    pays = presets.payouts_of(name)
    return Listed(
        name,
        # A table that is not solved has no digest on record.
        TABLES[name].digest if name in TABLES else Board.preset(name).digest,
        world,
        rows,
        risk,
        bins=rows + 1,
        pegs=rows * (rows + 5) // 2,
        size=(size * TRIANGLE_WIDTH, size * TRIANGLE_HEIGHT),
        multipliers=pays,
        returned=_returned(name),
    )


def takes_stakes(board: Board) -> bool:
    """Whether drops on this board may have a stake: only on presets whose return is known."""
    name = board.preset_name
    return name is not None and listed(name).stakes


def row_of(board: Board, world: str | None = None, returned: float | None = None) -> Listed:
    """The row of a board that is no triangle of a world."""
    return Listed(
        board.name,
        board.digest,
        world,
        None,
        None,
        bins=board.bins.count,
        pegs=len(board.pegs),
        size=(board.width, board.height),
        multipliers=board.bins.multipliers,
        returned=returned,
    )


def _returned(name: str) -> float | None:
    counted = shipped().get(presets.plain_name(name))
    return counted.odds(name)[0].returned if counted and name in counted.chosen else None
