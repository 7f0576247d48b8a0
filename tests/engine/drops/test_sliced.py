"""A path computed in slices has the same bits as one computed at once, wherever it is cut."""

import numpy as np
import pytest

from benchmarks.scenes.contact_scenes import scene, scene_names
from benchmarks.scenes.random_boards import random_board
from plinko.engine import Board, drop
from plinko.engine.drops import sliced
from plinko.engine.drops.flight import SlicedFlight, fly
from plinko.engine.drops.sliced import Slice, SlicedPath
from plinko.engine.drops.start import start_of
from plinko.engine.drops.trajectory import at_start, follow
from plinko.engine.errors import EffortError
from plinko.engine.exact.outcome import EVENT_LIMIT
from plinko.engine.parameters import Exact
from tests.long import tries


def in_slices(path: SlicedPath, sizes: "list[int]") -> list[Slice]:
    """All slices up to the end; their sizes repeat `sizes`."""
    parts: list[Slice] = []
    while not path.ended:
        parts.append(path.follow(sizes[len(parts) % len(sizes)]))
    return parts


def assert_same(board: Board, x: float, sizes: "list[int]", most: int = 100_000) -> int:
    """Assert that the drop is the same in slices; returns its number of events."""
    whole = follow(board, at_start(board, x), Exact(), most)
    path = SlicedPath(board, x, most)
    parts = in_slices(path, sizes)
    for name in ("impacts", "segments"):
        joined = np.concatenate([getattr(part, name) for part in parts])
        assert joined.tobytes() == getattr(whole, name).tobytes(), name
    assert path.state.tobytes() == whole.end.tobytes()
    assert (path.outcome, path.bin) == (whole.outcome, whole.bin)
    assert path.events == len(whole.events)
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
    limited = SlicedPath(board, x, 2)
    in_slices(limited, [1])
    assert limited.outcome == EVENT_LIMIT


def test_slices_get_shorter_where_a_call_takes_too_long(
    limited_calls: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """64 events on a preset take about 100,000 instructions."""
    monkeypatch.setattr(sliced, "EFFORT", 20_000)
    board = Board.preset("triangle-16")
    assert assert_same(board, start_of(board, 0, None), [64]) > 16
    path = SlicedPath(board, start_of(board, 0, None))
    assert 0 < len(path.follow(64).impacts) < 16


def test_a_single_event_that_takes_too_long_says_so(
    limited_calls: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = SlicedPath(Board.preset("triangle-8"), 0.01)
    path.follow(2)
    before = path.state.tobytes()
    monkeypatch.setattr(sliced, "EFFORT", 50)
    with pytest.raises(EffortError, match="trace_many has not ended after 50 instructions"):
        path.follow(64)
    assert (path.state.tobytes(), path.ended) == (before, False)


def test_a_flight_computed_in_slices_is_the_flight() -> None:
    board = scene("storm").board
    for seed in range(5):
        x = start_of(board, seed, None)
        sliced = SlicedFlight(board, x)
        while not sliced.advance(64):
            pass
        found, whole = sliced.flight(), fly(board, x)
        assert found.digest == whole.digest == drop(board, seed).digest
        assert found.path.segments.tobytes() == whole.path.segments.tobytes()


def test_what_has_ended_has_nothing_more() -> None:
    path = SlicedPath(Board.preset("triangle-8"), 0.01)
    in_slices(path, [1000])
    end = path.state.copy()
    part = path.follow(10)
    assert (len(part.impacts), len(part.segments)) == (0, 0)
    assert path.state.tobytes() == end.tobytes()
