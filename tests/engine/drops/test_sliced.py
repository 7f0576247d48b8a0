"""A path computed in slices has the same bits as one computed at once, wherever it is cut."""

from itertools import cycle

import numpy as np
import pytest

from benchmarks.scenes.contact_scenes import scene, scene_names
from benchmarks.scenes.random_boards import random_board
from plinko.engine import Board
from plinko.engine.drops import sliced
from plinko.engine.drops.flight import Flight
from plinko.engine.drops.sliced import SlicedFlight
from plinko.engine.drops.start import start_of
from plinko.engine.drops.trajectory import at_start, follow
from plinko.engine.errors import EffortError
from plinko.engine.exact.outcome import EVENT_LIMIT
from plinko.engine.parameters import Exact
from tests.long import tries


def in_slices(sliced: SlicedFlight, sizes: "list[int]") -> Flight:
    """The flight in slices whose sizes repeat `sizes`."""
    for size in cycle(sizes):
        if sliced.advance(size):
            break
    return sliced.flight()


def assert_same(board: Board, x: float, sizes: "list[int]", most: int = 100_000) -> int:
    """Assert that the drop is the same in slices; returns its number of events."""
    whole = follow(board, at_start(board, x), Exact(), most)
    found = in_slices(SlicedFlight(board, x, most), sizes)
    for name in ("impacts", "segments", "end"):
        joined = getattr(found.trajectory, name)
        assert joined.tobytes() == getattr(whole, name).tobytes(), name
    assert (found.trajectory.outcome, found.trajectory.bin) == (whole.outcome, whole.bin)
    assert found.digest == Flight(board, whole).digest
    return len(whole.events)


@pytest.mark.parametrize("name", scene_names())
def test_a_drop_may_be_cut_at_any_event(name: str) -> None:
    found = scene(name)
    x = start_of(found.board, None if found.x is not None else 1, found.x)
    most = tries(2000, 100_000)
    for sizes in ([1], [2], [3, 1, 7]):
        assert_same(found.board, x, sizes, most)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(tries(12, 400)))
def test_any_drop_on_any_board_may_be_cut_anywhere(seed: int) -> None:
    board = random_board(seed)
    sizes = np.random.default_rng(seed).integers(1, 9, 50).tolist()
    for ball in range(3):
        assert_same(board, start_of(board, ball, None), sizes, 3000)


def test_a_drop_without_end_ends_at_the_same_event() -> None:
    board = scene("storm").board
    x = start_of(board, 5, None)
    whole = len(follow(board, at_start(board, x), Exact()).events)
    for most in range(1, whole):
        assert_same(board, x, [4], most)
    limited = in_slices(SlicedFlight(board, x, 2), [1])
    assert limited.trajectory.outcome == EVENT_LIMIT


def test_slices_get_shorter_where_a_call_takes_too_long(
    limited_calls: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """64 events on a preset take about 100,000 instructions."""
    monkeypatch.setattr(sliced, "EFFORT", 20_000)
    board = Board.preset("triangle-16")
    assert assert_same(board, start_of(board, 0, None), [64]) > 16
    flight = SlicedFlight(board, start_of(board, 0, None))
    assert not flight.advance(64)
    assert 0 < len(flight.flight().trajectory.impacts) < 16


def test_a_single_event_that_takes_too_long_says_so(
    limited_calls: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    flight = SlicedFlight(Board.preset("triangle-8"), 0.01)
    assert not flight.advance(2)
    before = flight.flight().trajectory.end.tobytes()
    monkeypatch.setattr(sliced, "EFFORT", 50)
    with pytest.raises(EffortError, match="trace_many has not ended after 50 instructions"):
        flight.advance(64)
    assert flight.flight().trajectory.end.tobytes() == before


def test_what_has_ended_has_nothing_more() -> None:
    sliced = SlicedFlight(Board.preset("triangle-8"), 0.01)
    whole = in_slices(sliced, [1000])
    assert sliced.advance(10)
    assert sliced.flight().digest == whole.digest
