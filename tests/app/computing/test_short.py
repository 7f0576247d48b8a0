"""Short drops on presets that the server computes in its own process, within a time limit."""

import asyncio
import functools

import pytest

from plinko.app.computing.tasks import Ask, record
from plinko.app.errors import InvalidValueError
from plinko.app.web.computing import ShortDrops
from plinko.engine import Board, drop
from plinko.engine.drops import trajectory
from plinko.engine.errors import EffortError, ParameterError
from plinko.engine.parameters import Exact
from tests.kit.presets import SAMPLE

BOARD = Board.preset("triangle-12")


def work(seed: int, x: float | None = None) -> functools.partial[tuple[str, bytes]]:
    """The function that computes a drop's record."""
    return functools.partial(record, Ask(BOARD, seed, x, Exact()), False)


def test_a_drop_has_the_same_bits_here_and_its_time_is_counted() -> None:
    short = ShortDrops()
    for seed in range(100):
        done = short.measured(work(seed))
        assert done.value[0] == drop(BOARD, seed).digest
        assert done.seconds > 0.0


def test_a_drop_that_takes_too_long_is_stopped_the_next_one_not(
    limited_calls: None,
) -> None:
    done = ShortDrops(effort=10_000).measured(work(7))
    assert isinstance(done.error, EffortError)
    assert done.value is None
    assert ShortDrops().measured(work(7)).value[0] == drop(BOARD, 7).digest


def test_a_wrong_drop_is_its_own_error_a_fault_here_is_raised() -> None:
    short = ShortDrops()
    assert isinstance(short.measured(work(7, x=99.0)).error, ParameterError)

    def fail() -> None:
        raise InvalidValueError("not of a drop")

    with pytest.raises(InvalidValueError):
        short.measured(fail)
    assert short.measured(work(7)).error is None


async def test_a_preset_is_made_ready_once_while_the_loop_goes_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    begun: list[Board] = []
    monkeypatch.setattr(trajectory, "prepare", begun.append)
    short = ShortDrops()
    assert not short.is_ready(BOARD)
    while not short.is_ready(BOARD):
        await asyncio.sleep(0)
    assert begun == [BOARD]


def test_what_all_presets_need_is_kept_together() -> None:
    boards = [Board.preset(name) for name in SAMPLE]
    for board in boards:
        trajectory.prepare(board)
    kept = [trajectory._flights_of(board) for board in boards]
    assert kept == [trajectory._flights_of(board) for board in boards]
