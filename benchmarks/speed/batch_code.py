"""The same batch by different machine code, for benchmarks that compare them."""

from collections.abc import Callable, Mapping
from typing import Any

from plinko.engine import Board
from plinko.engine.constants import MAX_TIME
from plinko.engine.exact.board_arrays import arrays_of
from plinko.engine.exact.event_log import new_log
from plinko.engine.exact.initial_state import at_rest, in_flight
from plinko.engine.exact.lanes.trace import Code, Drops, trace_drops
from plinko.engine.exact.outcome import MAX_EVENTS, Results, new_results
from plinko.engine.exact.trace import trace_many
from plinko.engine.physics.contact import new_series


def alone(board: Board, xs: Any) -> Callable[[], Results]:
    """A batch of one ball after another, by the solver for one ball."""
    arrays, found = arrays_of(board), new_results(len(xs))

    def work() -> Results:
        trace_many(
            arrays, at_rest(xs, board.drop.y), in_flight(len(xs)), MAX_EVENTS, MAX_TIME,
            new_series(), new_log(0, 0), found.outcomes, found.bins, found.impacts,
        )  # fmt: skip
        return found

    return work


def side_by_side(board: Board, xs: Any, code: Mapping[str, Code]) -> Callable[[], Results]:
    """A batch in lanes, by this machine code."""
    arrays, found = arrays_of(board), new_results(len(xs))
    drops = Drops(xs, board.drop.y, MAX_EVENTS, MAX_TIME)

    def work() -> Results:
        trace_drops(arrays, drops, found, code)
        return found

    return work
