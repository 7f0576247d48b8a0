"""However slow a machine is, the same request gets the same answer or an error, never half."""

import itertools
import time
from collections.abc import Callable

import pytest

from plinko.app.computing import tasks
from plinko.app.errors import InvalidValueError
from plinko.engine import Board
from plinko.engine.parameters import Exact

BOARD = Board.preset("triangle-8")
MANY = tasks.Many(BOARD, 150, 77)


def search() -> object:
    return tasks.seeds_in(BOARD, 0, 0, 3, 100_000, None)


@pytest.mark.parametrize("seconds", [1e-6, 0.1, 1.0])
def test_a_slow_search_finds_the_same_seeds(
    monkeypatch: pytest.MonkeyPatch, seconds: float
) -> None:
    expected = search()
    readings = itertools.count()
    monkeypatch.setattr(time, "process_time", lambda: next(readings) * seconds)
    assert search() == expected


@pytest.mark.parametrize(
    ("work", "said"),
    [
        (search, "100 were done after 9 s"),
        (lambda: tasks.tally(BOARD, 0, 101, Exact()), "101 .* 100 were done"),
        (lambda: tasks.density(MANY, "png", 760, "light"), "too long"),
        (lambda: tasks.sheet(MANY, "png", 760, "light", columns=None), "too long"),
    ],
)
def test_work_that_is_too_slow_is_an_error_and_no_shorter_answer(
    monkeypatch: pytest.MonkeyPatch, work: Callable[[], object], said: str
) -> None:
    readings = itertools.count()
    monkeypatch.setattr(time, "process_time", lambda: next(readings) * 10.0)
    with pytest.raises(InvalidValueError, match=said) as refused:
        work()
    assert refused.value.field == "drops"
