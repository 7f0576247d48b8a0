"""The same batch by different machine code, for benchmarks that compare them."""

from collections.abc import Callable, Mapping
from typing import Any

from plinko.engine import Board
from plinko.engine.constants import MAX_TIME
from plinko.engine.exact.board_arrays import arrays_of
from plinko.engine.exact.lanes.trace import Code, Drops, trace_drops
from plinko.engine.exact.outcome import MAX_EVENTS, Results, new_results


def batch_by(board: Board, xs: Any, code: Mapping[str, Code]) -> Callable[[], Results]:
    """A batch in lanes by this native code, or without any, one ball after another."""
    arrays, found = arrays_of(board), new_results(len(xs))
    drops = Drops(xs, board.drop.y, MAX_EVENTS, MAX_TIME)

    def work() -> Results:
        trace_drops(arrays, drops, found, code)
        return found

    return work
