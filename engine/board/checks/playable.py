"""Checks a board as a whole, after its values were checked: this file has the order of the checks.

One error names all faults, simple ones first: overlaps and invalid starts. Only a board without
these is checked further: whether a ball can land in time, what it can reach, and where it would
get stuck.
"""

from plinko.engine.board.checks.fall_time import check_fall_time
from plinko.engine.board.checks.obstacles import close_discs, obstacles
from plinko.engine.board.checks.overlap import check_overlaps, check_start_above_bins, check_starts
from plinko.engine.board.checks.reach import check_hits_bins, check_passes, find_reach
from plinko.engine.board.checks.separators import separators
from plinko.engine.board.checks.shelves import check_shelves
from plinko.engine.board.checks.traps import check_traps
from plinko.engine.board.faults import Faults
from plinko.engine.board.fields import BoardFields


def check(board: BoardFields) -> None:
    """Raise BoardError if `board`, whose values are already checked, cannot be played."""
    obs = obstacles(board)
    pairs = close_discs(obs)
    faults = Faults()
    faults.take(check_start_above_bins, board)
    faults.take(check_overlaps, board, pairs)
    faults.take(check_starts, board, obs)
    faults.end()
    faults.take(check_fall_time, board)
    lines = separators(obs, pairs, board.drop.y, board.bins.y)
    reach = faults.take(find_reach, board, obs, lines)
    if reach is not None:
        faults.take(check_passes, board, reach)
        faults.take(check_hits_bins, board, obs, reach)
        faults.take(check_traps, board, obs, pairs, reach)
    faults.take(check_shelves, board, obs)
    faults.end()
