"""Short drops on presets that the server computes in its own process, within a time limit."""

import asyncio
import contextlib
import time

import pytest

from plinko.app.computing.prices import Price
from plinko.app.computing.tasks import Ask, record
from plinko.app.web.computing import Computing
from plinko.app.web.limits import Budgets
from plinko.engine import Board, drop
from plinko.engine.drops import trajectory
from plinko.engine.errors import EffortError, ParameterError
from plinko.engine.parameters import Exact
from tests.kit.presets import SAMPLE

BOARD = Board.preset("triangle-12")
PRICE = Price("events", 1.0, 1.0, 0.5, preset=BOARD)


def at_once(computing: Computing, seed: int, x: float | None = None) -> tuple[str, bytes]:
    """A drop's digest and record."""
    return computing.at_once("Ada", PRICE, record, Ask(BOARD, seed, x, Exact()), False)


def test_a_drop_has_the_same_bits_here() -> None:
    computing = Computing(1)
    for seed in range(100):
        assert at_once(computing, seed)[0] == drop(BOARD, seed).digest


def test_a_drop_that_takes_too_long_is_stopped_the_next_one_not(
    limited_calls: None,
) -> None:
    computing = Computing(1)
    computing.effort = 10_000
    with pytest.raises(EffortError):
        at_once(computing, 7)
    assert at_once(Computing(1), 7)[0] == drop(BOARD, 7).digest


@pytest.mark.parametrize("x", [None, 99.0], ids=["a drop", "a wrong start"])
def test_a_client_pays_the_time_that_a_drop_took_here(x: float | None) -> None:
    computing = Computing(1)
    computing.budgets = Budgets(rate=1e-9, burst=1.0)
    with contextlib.suppress(ParameterError) if x else contextlib.nullcontext():
        at_once(computing, 7, x)
    left = computing.budgets.allowance("Ada", time.monotonic(), "computing-ms").left
    assert 900 < left < 1000, "more than nothing, and less than its price of half a second"


async def test_a_preset_is_made_ready_once_while_the_loop_goes_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    begun: list[Board] = []
    monkeypatch.setattr(trajectory, "prepare", begun.append)
    computing = Computing(1)
    assert not computing.is_short(PRICE)
    while not computing.is_short(PRICE):
        await asyncio.sleep(0)
    assert begun == [BOARD]


def test_what_all_presets_need_is_kept_together() -> None:
    boards = [Board.preset(name) for name in SAMPLE]
    for board in boards:
        trajectory.prepare(board)
    kept = [trajectory._flights_of(board) for board in boards]
    assert kept == [trajectory._flights_of(board) for board in boards]
