"""Checks a board as a whole, once its values are right: the order of the checks, and nothing else.

Errors come in the order in which they are easiest to understand: what overlaps, where a ball
starts, where it can get, where it would stick. The first two are named together; the others only
mean something on a board without them.
"""

from engine.board.checks.fall_time import check_fall_time
from engine.board.checks.obstacles import close_discs, obstacles
from engine.board.checks.overlap import check_overlaps, check_start_above_bins, check_starts
from engine.board.checks.reach import check_reach
from engine.board.checks.separators import separators
from engine.board.checks.shelves import check_shelves
from engine.board.checks.traps import check_traps
from engine.board.faults import Faults
from engine.board.fields import BoardFields


def check(board: BoardFields) -> None:
    """Raise BoardError if `board` cannot be played; its values have been checked one by one."""
    obs = obstacles(board)
    pairs = close_discs(obs)
    faults = Faults()
    faults.take(check_start_above_bins, board)
    faults.take(check_overlaps, board, pairs)
    faults.take(check_starts, board, obs)
    faults.end()
    check_fall_time(board)
    reach = check_reach(board, obs, separators(obs, pairs, board.drop.y, board.bins.y))
    check_traps(board, obs, pairs, reach)
    check_shelves(board, obs)
