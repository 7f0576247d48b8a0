"""Garbage: none collected in the middle of a tick, all of it collected in the end."""

import gc
import weakref
from collections.abc import Iterator

import pytest

from app import garbage
from app.garbage import GarbageKeeper


class Ring:
    """Garbage that only the collector can find."""

    def __init__(self) -> None:
        self.self = self


@pytest.fixture
def keeper() -> Iterator[GarbageKeeper]:
    gc.collect()
    yield GarbageKeeper()
    gc.enable()


def test_the_collector_rests_while_the_ticker_runs_and_only_then(keeper: GarbageKeeper) -> None:
    keeper.woke()
    assert not gc.isenabled()
    keeper.slept()
    assert gc.isenabled()


def test_between_ticks_garbage_is_collected_once_there_is_enough(keeper: GarbageKeeper) -> None:
    keeper.woke()
    ring = weakref.ref(Ring())
    keeper.ticked(0.0, 0.0)
    assert ring() is not None, "a handful of objects is not worth a collection"
    kept = [[] for _ in range(garbage.YOUNG)]  # type: ignore[var-annotated]
    keeper.ticked(0.0, 0.0)
    assert ring() is None
    assert keeper.collections == 1
    del kept


def test_what_grew_old_before_it_became_garbage_is_found_too(
    keeper: GarbageKeeper, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(garbage, "FULL", 10)
    keeper.woke()
    old = Ring()
    gc.collect()
    ring = weakref.ref(old)
    del old
    for _ in range(10):
        keeper.ticked(0.0, 0.0)
    assert ring() is None
