"""One drop: its record, its states at any time, and the values that it refuses."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import plinko
from benchmarks.scenes.contact_scenes import scene
from plinko.engine import Board, ParameterError, PlinkoError, SeedError, drop
from plinko.engine.board.parts import DropZone
from plinko.engine.canonical import float_bits
from plinko.engine.constants import KIND_LANDING, PHYSICS_VERSION
from plinko.engine.drops.digest import drop_digest
from plinko.engine.drops.trajectory import impacts_of
from plinko.engine.parameters import Exact, SolverName, Stepped
from plinko.engine.seeding import start_x
from tests.engine.multibody.static_scenes import place

TRIANGLE = Board.preset("triangle-16")
CLASSIC = Board.preset("classic")

SOLVERS = ["exact", "stepped"]


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_drop_ends_with_its_landing(solver: SolverName) -> None:
    for seed in range(20):
        found = drop(TRIANGLE, seed, solver=solver)
        t, x, y, _, vy, _, kind, index = found.impacts[-1]
        assert kind == KIND_LANDING
        assert index == found.bin
        assert (t, x) == (found.duration, found.x_end)
        assert y == pytest.approx(TRIANGLE.bins.y, abs=1e-14)
        assert vy > 0.0
        edges = TRIANGLE.bins.edges
        assert edges[found.bin or 0] <= x < edges[(found.bin or 0) + 1]
        assert found.score == TRIANGLE.bins.multipliers[found.bin or 0]
        assert found.unsettled is None


def test_the_seed_alone_says_where_a_drop_starts() -> None:
    zone = TRIANGLE.drop
    for seed in (0, 1, 42, 2**64 - 1):
        found = drop(TRIANGLE, seed)
        assert found.x_start == start_x(seed, zone.x, zone.jitter)
        assert drop(TRIANGLE, x=found.x_start).digest == found.digest
        assert drop(TRIANGLE, str(seed)).digest == found.digest


def test_an_explicit_start_wins_over_the_seed_and_may_be_a_slot() -> None:
    for slot in CLASSIC.slots:
        found = drop(CLASSIC, 7, x=slot)
        assert found.x_start == slot
        assert found.seed == 7
        assert found.explicit_x


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("name", ["triangle-16", "classic"])
def test_states_are_the_same_bits_in_any_order_of_asking(solver: SolverName, name: str) -> None:
    found = drop(Board.preset(name), 3, solver=solver)
    times = np.linspace(0.0, found.duration * 1.1, 301)
    inorder = found.states(times)
    shuffled = np.random.default_rng(5).permutation(len(times))
    assert found.states(times[shuffled]).tobytes() == inorder[shuffled].tobytes()
    one_by_one = np.concatenate([found.states(t) for t in times])
    assert one_by_one.tobytes() == inorder.tobytes()
    again = drop(Board.preset(name), 3, solver=solver)
    assert again.states(times).tobytes() == inorder.tobytes()


@pytest.mark.parametrize("solver", SOLVERS)
def test_states_begin_at_rest_and_stay_where_the_ball_ended(solver: SolverName) -> None:
    found = drop(TRIANGLE, 3, solver=solver)
    first, last, later = found.states([0.0, found.duration, found.duration + 1e6])
    assert (first["t"], first["x"], first["y"]) == (0.0, found.x_start, TRIANGLE.drop.y)
    if solver == "exact":
        assert (first["vx"], first["vy"], first["omega"]) == (0.0, 0.0, 0.0)
    assert last["x"] == later["x"] == found.x_end
    assert last["y"] == pytest.approx(TRIANGLE.bins.y, abs=1e-14)
    assert later["t"] == found.duration + 1e6


@pytest.mark.parametrize("name", ["triangle-16", "scene:low-restitution", "scene:zigzag"])
def test_states_are_continuous_but_for_velocities_at_impacts(name: str) -> None:
    board = scene(name[6:]).board if name.startswith("scene:") else Board.preset(name)
    for seed in range(3):
        found = drop(board, seed)
        times = found.impacts["t"]
        after, before = found.states(times), found.states(np.maximum(times - 1e-9, 0.0))
        fastest = 2.0 * math.sqrt(2.0 * board.gravity * board.bins.y)
        for field in ("x", "y"):
            assert abs(after[field] - before[field]).max() <= 1e-9 * fastest + 1e-12
            assert abs(after[field] - found.impacts[field]).max() <= 1e-12
        unique = np.append(
            np.diff(times) > 0.0, True
        )  # if several events share an instant, the last one counts
        for field in ("vx", "vy", "omega"):
            assert abs(after[field] - found.impacts[field])[unique].max() <= 1e-8


@pytest.mark.parametrize("bad", [-1e-9, -math.inf, math.nan])
def test_a_time_before_the_start_is_refused(bad: float) -> None:
    with pytest.raises(ParameterError, match=r"time (-1e-09|-inf|nan) is before") as caught:
        drop(TRIANGLE, 1).states([0.0, bad])
    assert caught.value.field == "times"


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_record_is_json_and_holds_the_drop(solver: SolverName) -> None:
    found = drop(TRIANGLE, 42, solver=solver)
    record = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    expected = ["board", "board_digest", "seed", "solver", "physics_version"]
    expected += ["bin", "score", "duration", "x_end", "impacts", "digest"]
    if solver == "stepped":
        expected[4:4] = ["dt", "substeps", "correction"]
    assert list(record) == expected
    assert record["board"] == "triangle-16"
    assert record["seed"] == "42"
    assert record["physics_version"] == PHYSICS_VERSION
    assert record["impacts"] == [list(row) for row in found.impacts.tolist()]
    assert record["duration"] == found.duration
    assert record["digest"] == found.digest


@pytest.mark.parametrize("certainty", [False, True])
def test_a_records_text_is_what_python_writes_of_its_values(certainty: bool) -> None:
    """This includes numbers with an exponent, which few drops have."""
    exponents = 0
    for seed in range(150):
        found = drop(TRIANGLE, seed)
        text = found.to_json(certainty=certainty)
        record = found.to_dict(certainty=certainty)
        assert text == json.dumps(record, ensure_ascii=False, allow_nan=False)
        exponents += "e-" in json.dumps(record["impacts"])
    assert 0 < exponents < 75


def test_a_record_of_a_board_of_ones_own_carries_the_board() -> None:
    board = scene("zigzag").board
    record = json.loads(json.dumps(drop(board, x=-1.5).to_dict()))
    assert Board.from_json(record["board"]).digest == board.digest == record["board_digest"]
    assert record["seed"] is None
    assert record["x"] == -1.5


def test_the_digest_is_over_all_that_can_differ() -> None:
    digests = [
        drop(TRIANGLE, 42).digest,
        drop(TRIANGLE, 43).digest,
        drop(Board.preset("triangle-16-low"), 42).digest,
        drop(TRIANGLE, 42, solver="stepped").digest,
        drop(TRIANGLE, 42, solver="stepped", substeps=5).digest,
        drop(TRIANGLE, 42, solver="stepped", dt=1.0 / 30.0).digest,
        drop(TRIANGLE, 42, solver="stepped", correction=0.5).digest,
        drop(TRIANGLE, x=math.nextafter(drop(TRIANGLE, 42).x_start, 1.0)).digest,
    ]
    assert len(set(digests)) == len(digests)
    assert all(len(digest) == 64 for digest in digests)


def test_each_part_of_a_drop_is_in_its_digest() -> None:
    events = np.arange(12.0).reshape(2, 6)
    marks = np.array([[0, 3], [5, 1]], np.int32)
    start = (0.1, 0.0, 0.0, 0.0, 0.0)
    board = "00" * 32
    base = drop_digest(board, Exact(), start, 0, impacts_of(events, marks))
    changed = events.copy()
    changed[1, 5] = math.nextafter(changed[1, 5], 100.0)
    marked = marks.copy()
    marked[0, 1] = 4
    others = [
        drop_digest("01" + board[2:], Exact(), start, 0, impacts_of(events, marks)),
        drop_digest(board, Stepped(), start, 0, impacts_of(events, marks)),
        drop_digest(board, Exact(), (0.1, 0.0, 0.0, 0.0, -0.0), 0, impacts_of(events, marks)),
        drop_digest(board, Exact(), start, 1, impacts_of(events, marks)),
        drop_digest(board, Exact(), start, 0, impacts_of(events[:1], marks[:1])),
        drop_digest(board, Exact(), start, 0, impacts_of(changed, marks)),
        drop_digest(board, Exact(), start, 0, impacts_of(events, marked)),
    ]
    assert len({base, *others}) == len(others) + 1


def test_every_nan_has_the_same_bits_in_a_digest() -> None:
    signed = np.array([0xFFF8000000000000, 0x7FF0000000000001, 0x7FF8000000000000], np.uint64)
    assert len({bits.tobytes() for bits in float_bits(signed.view(np.float64))}) == 1
    events = np.repeat(signed.view(np.float64), 6).reshape(3, 6)
    rows = impacts_of(events, np.zeros((3, 2), np.int32))
    assert len({row.tobytes() for row in rows}) == 1


def test_no_seed_and_no_start_is_refused() -> None:
    with pytest.raises(ParameterError, match="a seed or an explicit x"):
        drop(TRIANGLE)


@pytest.mark.parametrize("x", [math.nan, math.inf, -math.inf, 100.0, -100.0, "0.1", True])
def test_an_invalid_start_is_refused_with_its_value(x: object) -> None:
    with pytest.raises(ParameterError) as caught:
        drop(TRIANGLE, 1, x=x)  # type: ignore[arg-type]
    assert caught.value.field == "x"
    assert repr(x) in str(caught.value)


def test_the_drop_zone_ends_where_its_jitter_and_its_slots_end() -> None:
    board = place(drop=DropZone(0.25, 0.0, 0.1, slots=(0.0, 0.5)))
    for x in (0.15, 0.35, *board.slots):
        assert drop(board, x=x).x_start == x
    with pytest.raises(ParameterError):
        drop(board, x=math.nextafter(0.5, math.inf))


def test_a_start_reaches_as_far_as_boards_seeds_only_the_jitter() -> None:
    board = place(drop=DropZone(0.25, 0.0, 0.1, reach=0.5))
    for x in (-0.25, 0.75):
        assert drop(board, x=x).x_start == x
        with pytest.raises(ParameterError):
            drop(board, x=math.nextafter(x, math.copysign(math.inf, x)))
    assert {abs(drop(board, seed).x_start - 0.25) <= 0.1 for seed in range(99)} == {True}
    assert place(drop=DropZone(0.25, 0.0, 0.1)).digest != board.digest


@given(st.integers(0, 2**64 - 1))
def test_any_seed_is_a_drop_that_lands_or_says_why_not(seed: int) -> None:
    for board in (TRIANGLE, CLASSIC):
        found = drop(board, seed)
        assert (found.bin is None) is (found.unsettled is not None)
        assert found.duration > 0.0
        assert np.isfinite(found.trajectory.events).all()
        assert len(found.impacts) < 5000


def test_the_error_tree_has_one_root() -> None:
    errors = [getattr(plinko, name) for name in plinko.__all__ if name.endswith("Error")]
    assert {ParameterError, SeedError, plinko.InvalidValueError, plinko.ClusterError} <= set(errors)
    for error in errors:
        assert issubclass(error, PlinkoError)
    not_about_values = {PlinkoError, plinko.ClusterError, plinko.MissingPartError}
    assert {each for each in errors if not issubclass(each, ValueError)} == not_about_values
    assert issubclass(plinko.MissingPartError, ImportError)
    with pytest.raises(PlinkoError, match="pink"):
        plinko.drop_picture(drop("triangle-8", 1), theme="pink")  # type: ignore[arg-type]


def test_a_board_without_jitter_starts_at_its_point() -> None:
    board = place(drop=DropZone(0.25, 0.0, 0.0))
    assert {drop(board, seed).x_start for seed in range(9)} == {0.25}
