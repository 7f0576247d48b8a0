"""The log of many balls has the same events that each ball alone would have."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from plinko.engine import Board, drop
from plinko.engine.constants import MAX_TIME
from plinko.engine.exact import event_log
from plinko.engine.exact.board_arrays import arrays_of
from plinko.engine.exact.event_log import Log, new_log
from plinko.engine.exact.initial_state import at_rest, in_flight
from plinko.engine.exact.outcome import MAX_EVENTS
from plinko.engine.exact.trace import trace_many
from plinko.engine.parameters import SolverName, Stepped
from plinko.engine.physics import body
from plinko.engine.physics.contact import new_series
from plinko.engine.stepped.step import step_many, trace_stepped_many

BOARD = Board.preset("triangle-8")
SEEDS = (3, 1, 4, 1, 5)


def exact(states: Any, log: Log, results: Any) -> None:
    trace_exact(states, MAX_EVENTS, log, results)


def trace_exact(states: Any, max_events: int, log: Log, results: Any) -> None:
    initial = in_flight(len(states))
    trace_many(arrays_of(BOARD), states, initial, max_events, MAX_TIME, new_series(), log, *results)


def stepped(states: Any, log: Log, results: Any) -> None:
    h, correction = Stepped().h, Stepped().correction
    trace_stepped_many(arrays_of(BOARD), states, h, correction, MAX_EVENTS, log, *results)


def started() -> Any:
    return at_rest(np.array([drop(BOARD, seed).x_start for seed in SEEDS]), BOARD.drop.y)


def results_of(n: int) -> tuple[Any, Any, Any]:
    return np.empty(n, np.int8), np.empty(n, np.int32), np.empty(n, np.int32)


@pytest.mark.parametrize(("solver", "trace"), [("exact", exact), ("stepped", stepped)])
def test_balls_of_one_log_are_told_apart(solver: SolverName, trace: Callable[..., None]) -> None:
    states, results = started(), results_of(len(SEEDS))
    log = new_log(2000, 20_000, len(SEEDS))
    trace(states, log, results)
    begun = np.zeros(event_log.COUNTS, np.int64)
    for i, seed in enumerate(SEEDS):
        alone = drop(BOARD, seed, solver=solver).trajectory
        events = slice(begun[event_log.EVENTS], log.ends[i, event_log.EVENTS])
        segments = slice(begun[event_log.SEGMENTS], log.ends[i, event_log.SEGMENTS])
        assert np.array_equal(log.events[events], alone.events)
        assert np.array_equal(log.marks[events], alone.marks)
        assert np.array_equal(log.segments[segments], alone.segments)
        assert np.array_equal(states[i], alone.end)
        impacts = log.ends[i, event_log.IMPACTS] - begun[event_log.IMPACTS]
        assert [each[i] for each in results] == [alone.outcome, alone.bin, impacts]
        begun = log.ends[i]
    assert np.array_equal(log.counts, log.ends[-1])


def test_each_ball_of_a_log_has_all_the_events_it_may_have() -> None:
    """The limit of events applies to each ball separately."""
    states, results = started(), results_of(len(SEEDS))
    log = new_log(0, 0, len(SEEDS))
    trace_exact(states, 4, log, results)
    assert np.diff(log.ends[:, event_log.EVENTS], prepend=0).tolist() == [4] * len(SEEDS)


def test_steps_taken_a_few_at_a_time_are_those_of_the_whole_drop() -> None:
    whole = drop(BOARD, 3, solver="stepped").trajectory
    states, results = started()[:1], results_of(1)
    steps, log = np.zeros(1, np.int64), new_log(1000, 0)
    h, correction = Stepped().h, Stepped().correction
    for few in (1, 7, 100, 1 << 40):
        step_many(
            arrays_of(BOARD), states, steps, few, h, correction, MAX_EVENTS,
            np.empty(body.SIZE), log, *results,
        )  # fmt: skip
    assert np.array_equal(states[0], whole.end)
    assert np.array_equal(log.events[: log.counts[event_log.EVENTS]], whole.events)
    assert (results[0][0], results[1][0]) == (whole.outcome, whole.bin)
