"""The exact solver agrees with the fifty-digit oracle in positions, impacts and bins."""

import math
import statistics
from collections.abc import Iterator
from itertools import product

import mpmath
import pytest

from benchmarks.scenes.contact_scenes import scene as shared_scene
from benchmarks.scenes.contact_scenes import scene_names
from plinko.engine import drop
from plinko.engine.board.model import Board
from plinko.engine.board.parts import Bins, Peg, Wall
from plinko.engine.constants import (
    KIND_CONTACT_BEGIN,
    KIND_CONTACT_CHANGE,
    KIND_CONTACT_END,
    KIND_PEG,
    KIND_WALL,
)
from tests.long import many, tries
from tools.oracle import OracleDrop, golden, oracle_drop
from tools.oracle.golden import GoldenDrop
from tools.oracle.random_scenes import random_scene
from tools.oracle.scenes import accuracy_boards, scene

mp = mpmath.MPContext()
mp.dps = 60

BOARDS = sorted(accuracy_boards())
HIT, BEGIN, CHANGE, END = KIND_PEG, KIND_CONTACT_BEGIN, KIND_CONTACT_CHANGE, KIND_CONTACT_END
FIRST_IMPACTS = 4
WORST = 1e-10  # m, after the first four impacts
MEDIAN = 1e-13  # m
# Rounding error of one flight and one impact, in ulps of the coordinates; observed: about 2.
ULPS = 32


def errors(oracle: OracleDrop, board: Board, x: float) -> list[float]:
    """Distances in m between oracle and solver at each event; the events must be equal."""
    played = drop(board, x=x)
    assert golden.turns_of(played.impacts) == golden.turns_of(oracle.events)
    assert played.bin == oracle.bin
    return [
        math.hypot(float(e.x - float(i["x"])), float(e.y - float(i["y"])))
        for e, i in zip(oracle.events, played.impacts, strict=True)
    ]


def assert_agrees(board: Board, x: float) -> OracleDrop:
    """Assert equal events, bin, and positions within grown rounding; returns the oracle's."""
    oracle = oracle_drop(board, x)
    found = errors(oracle, board, x)
    rounding = ULPS * math.ulp(max(1.0, abs(float(board.bins.y))))
    if max(found) > rounding:  # only then compute how far rounding grows, which is slow
        for number, (error, growth) in enumerate(zip(found, oracle.growths, strict=True)):
            assert growth < golden.SHARP, "a scene too chaotic to compare"
            assert error <= rounding * max(1.0, growth), (number, error, growth)
    return oracle


def kinds(oracle: OracleDrop) -> list[int]:
    return [e.kind for e in oracle.events]


# Whole boards, against the committed files.


@pytest.mark.parametrize("name", BOARDS)
def test_the_oracle_files_are_of_the_boards_as_they_are(name: str) -> None:
    head, drops = golden.load(name)
    board = accuracy_boards()[name]
    assert head["board_digest"] == board.digest, (
        f"{name} has changed: run python -m tools.oracle.make {name}"
    )
    assert [d.x for d in drops] == golden.starts(board, len(drops))
    assert len(drops) >= 40


@pytest.mark.long
@pytest.mark.parametrize("name", tries(["trial-8"], BOARDS))
def test_the_oracle_files_say_what_the_oracle_says(name: str) -> None:
    """Recompute one drop of each file, and several in `make test-long`, which checks new files."""
    board = accuracy_boards()[name]
    _, drops = golden.load(name)
    short = sorted(drops, key=lambda d: len(d.turns))
    for kept in short[len(short) // 4 :][: tries(1, 4)]:
        assert golden.compute(board, kept.x) == kept


@pytest.mark.parametrize("name", BOARDS)
def test_the_ball_goes_where_the_oracle_says_as_far_as_doubles_can_decide(name: str) -> None:
    """Positions at the first impacts, the surfaces that are hit, and the bin."""
    board = accuracy_boards()[name]
    _, drops = golden.load(name)
    found: list[float] = []
    sure = 0
    for kept in drops:
        played = drop(board, x=kept.x)
        found.append(max(golden.position_errors(kept, played.impacts, FIRST_IMPACTS)))
        turns = golden.turns_of(played.impacts).split()
        assert turns[: kept.sharp] == kept.turns.split()[: kept.sharp]
        if golden.decidable(kept, board):
            sure += 1
            assert played.bin == kept.bin
            assert abs(float(kept.end - played.x_end)) <= golden.bound(kept)
    assert max(found) <= WORST
    assert statistics.median(found) <= MEDIAN
    # A test of nothing would pass too. Without air and friction errors grow to metres on the way:
    # of the drops on plain-12 a quarter can be decided, of those with drag at least three quarters.
    assert sure >= (0.7 if board.drag > 0 else 0.1) * len(drops)


# One law at a time, computed here.


def laws() -> Iterator[tuple[str, Board, float, list[int]]]:
    """Name, board, start, and the kinds of events that the ball then has, in this order."""
    yield "a parabola and a bounce", scene(pegs=(Peg(0.0, 0.0, 0.3),), restitution=0.7), 0.1, [HIT]
    pegs = (Peg(0.0, 0.0, 0.2), Peg(0.9, 0.9, 0.4), Peg(1.2, 0.1, 0.05))
    for drag, friction in product((0.01, 0.1, 1.0, 5.0), (0.0, 0.3)):
        board = scene(pegs=pegs, restitution=0.6, drag=drag, friction=friction)
        yield f"air of {drag}, friction {friction}", board, 0.1, [HIT]
    for friction in (0.05, 0.3, 1.0):
        slope = (Wall(-1.0, -0.2, 1.5, 0.8),)
        board = scene(walls=slope, restitution=0.7, friction=friction)
        yield f"many bounces on a slope, friction {friction}", board, -0.7, [KIND_WALL] * 2
    for drag, (friction, x) in product((0.0, 2.0), ((0.0, 0.01), (0.05, 0.2), (0.4, 0.01))):
        board = scene(pegs=(Peg(0.0, 0.0, 0.4),), friction=friction, drag=drag)
        changes = [CHANGE] * (friction == 0.4)
        yield f"over a peg, {friction}, air {drag}", board, x, [BEGIN, *changes, END]
    # From a steep wall the ball slides onto a shallow one; the second change is at its end.
    walls: tuple[Wall, ...] = (Wall(-1.0, -1.0, -0.4, 0.0), Wall(-0.45, 0.2, 1.5, 0.25))
    board = scene(walls=walls, friction=0.05, restitution=0.2, start_y=-1.6)
    yield "too fast to roll, it slides until it rolls", board, -0.95, [CHANGE, CHANGE]
    # It falls off-centre on the end of an upright, slanted or nearly level wall.
    for far, offset, e in product(
        ((0.0, 1.0), (0.3, 0.9), (-0.9, 0.2)), (-0.0999, -0.05, 0.001, 0.0999), (0.0, 0.5)
    ):
        board = scene(walls=(Wall(*far, 0.0, 0.0),), restitution=e, friction=0.2)
        yield f"the end of a wall from {far}, {offset}, {e}", board, offset, [KIND_WALL]
    for y, friction in product((0.001953125, 0.0625, 0.5), (0.0, 0.5)):
        walls = (Wall(-1.0, 0.0, 0.0, y), Wall(0.05, 1.2, 1.5, 1.5))
        yield f"off a wall, {y}, {friction}", scene(walls=walls, friction=friction), -0.05, [END]
    for bend in (0.07, 0.2, 0.8):
        walls = (Wall(-1.0, 0.0, 0.0, 0.0625), Wall(0.0, 0.0625, 1.0, 0.0625 + bend))
        yield f"over a ridge, {bend}", scene(walls=walls, friction=0.9), -0.05, [BEGIN]


@pytest.mark.parametrize(
    ("board", "x", "wanted"), [pytest.param(*law, id=name) for name, *law in laws()]
)
def test_one_law_at_a_time(board: Board, x: float, wanted: list[int]) -> None:
    oracle = assert_agrees(board, x)
    phases = [kind for kind in kinds(oracle) if kind in (BEGIN, CHANGE, END)]
    if {BEGIN, END} <= {*wanted}:  # all phases of the only contact
        assert phases == wanted
    else:
        assert [kind for kind in kinds(oracle) if kind in wanted][: len(wanted)] == wanted
    spin = max(abs(event.omega) for event in oracle.events)
    assert (spin > 0.5) == (board.ball.friction > 0.0)


@pytest.mark.parametrize("x", [-0.5, 0.0, 0.7])
@pytest.mark.parametrize("slope", [-0.6, 0.0, 0.3])
def test_the_inside_of_a_wall(x: float, slope: float) -> None:
    walls: tuple[Wall, ...] = (Wall(-1.0, -slope, 1.0, slope),)
    if slope == 0.0:
        walls += (Wall(-1.2, 1.5, 1.2, 1.0),)
    board = scene(walls=walls, restitution=0.5, friction=0.1, drag=0.5)
    oracle = oracle_drop(board, x, max_events=15)
    played = drop(board, x=x)
    for e, i in zip(oracle.events, played.impacts, strict=False):
        assert math.hypot(float(e.x - float(i["x"])), float(e.y - float(i["y"]))) < 1e-14


def test_rolling_into_a_peg_and_into_a_wall() -> None:
    slope = Wall(-1.0, -0.25, 1.0, 0.25)
    for stop in (Peg(0.5, 0.0, 0.05), Peg(0.9, 0.0, 0.15)):
        board = scene(walls=(slope,), pegs=(stop,), friction=0.9)
        oracle, played = oracle_drop(board, -0.5), drop(board, x=-0.5)
        assert kinds(oracle)[:3] == [KIND_WALL, KIND_CONTACT_BEGIN, KIND_PEG]
        # It ends in the notch, where the order of events depends on the last digits.
        assert oracle.bin is None
        assert played.bin is None
        for e, i in zip(oracle.events[:6], played.impacts, strict=False):
            assert (e.kind, e.index) == (i["kind"], i["index"])
            assert math.hypot(float(e.x - float(i["x"])), float(e.y - float(i["y"]))) < 1e-14


# Grazes.


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("overlap", [1e-4, 1e-8, 1e-12, 1e-15])
@pytest.mark.parametrize("drag", [0.0, 1.0])
def test_a_vertical_graze_of_a_peg_hits_or_misses_by_geometry(
    side: float, overlap: float, drag: float
) -> None:
    board = scene(pegs=(Peg(0.0, 0.0, 0.25),), radius=0.25, restitution=0.5, drag=drag)
    hit = assert_agrees(board, side * (0.5 - overlap))
    assert kinds(hit)[0] == KIND_PEG
    assert kinds(assert_agrees(board, side * (0.5 + overlap))) == [5]


@pytest.mark.parametrize("overlap", [1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("drag", [0.0, 2.0])
def test_a_curved_graze_of_a_peg_is_decided_to_a_picometre(overlap: float, drag: float) -> None:
    """The ball bounces off a slope and flies past a peg, which it just touches or misses."""
    slope = Wall(-0.5, -0.5, 0.5, 0.5)
    bare = oracle_drop(scene(walls=(slope,), restitution=1.0, drag=drag), 0.0)
    distance = closest(bare, (1.0, 0.5))
    for grown, wanted in ((overlap, True), (-overlap, False)):
        peg = Peg(1.0, 0.5, float(distance) - 0.1 + grown)
        board = scene(walls=(slope,), pegs=(peg,), restitution=1.0, drag=drag)
        played = drop(board, x=0.0)
        oracle = oracle_drop(board, 0.0)
        assert golden.turns_of(played.impacts) == golden.turns_of(oracle.events)
        assert (KIND_PEG in kinds(oracle)) is wanted
        # A graze of overlap d is met at an angle of about sqrt(2 d / D): its place is known to
        # rounding over that angle.
        for e, i in zip(oracle.events[:-1], played.impacts[:-1], strict=True):
            error = math.hypot(float(e.x - float(i["x"])), float(e.y - float(i["y"])))
            assert error < 1e-14 / math.sqrt(overlap)


def closest(path: OracleDrop, point: tuple[float, float]) -> mpmath.mpf:
    """Smallest distance in m of the last flight of `path` from a point (golden-section search)."""
    low, high = path.events[0].t, path.duration
    ratio = (mp.sqrt(5) - 1) / 2

    def distance(t: mpmath.mpf) -> mpmath.mpf:
        x, y = path.position_at(t)
        return mp.hypot(x - point[0], y - point[1])

    for _ in range(90):
        left, right = high - ratio * (high - low), low + ratio * (high - low)
        if distance(left) < distance(right):
            high = right
        else:
            low = left
    return distance((low + high) / 2)


@pytest.mark.parametrize("miss", [-1e-12, 1e-12])
def test_a_graze_of_a_wall_s_end_hits_or_misses_by_geometry(miss: float) -> None:
    """The ball falls vertically past the end of an upright wall."""
    board = scene(walls=(Wall(0.0, 0.0, 0.0, 1.0),), radius=0.25, restitution=0.5)
    assert (kinds(assert_agrees(board, 0.25 + miss)) == [5]) is (miss > 0)


# The scenes that tests, benchmarks and demos share.

QUIET = ("apex", "shelf", "ramp", "slide", "zigzag", "polyline", "comb", "dead")


@pytest.mark.parametrize("name", QUIET)
def test_the_shared_scenes_play_as_by_the_oracle(name: str) -> None:
    assert name in scene_names()
    shared = shared_scene(name)
    x = shared.board.drop.x if shared.x is None else shared.x
    oracle = oracle_drop(shared.board, x)
    found = errors(oracle, shared.board, x)
    assert max(found) < 1e-13 if name != "apex" else max(found) < 1e-15


# Random boards. All seeds from 0 to 59 agreed; these were chosen for what happens on them.


@pytest.mark.parametrize(
    "seed", [*(2, 3, 9, 11, 26, 33, 49, 51, 55), *(many(seed) for seed in (0, 20, 31, 46, 47))]
)
def test_on_a_random_board_the_ball_does_what_the_oracle_says(seed: int) -> None:
    board, x = random_scene(seed)
    oracle = oracle_drop(board, x)
    found = errors(oracle, board, x)
    rounding = ULPS * math.ulp(float(board.bins.y))
    if max(found) > rounding:
        for error, growth in zip(found, oracle.growths, strict=True):
            assert error <= rounding * max(1.0, growth)


@pytest.mark.parametrize("seed", [18, many(34), 38, many(58)])
def test_where_the_oracle_is_stuck_in_a_notch_the_ball_is_too(seed: int) -> None:
    board, x = random_scene(seed)
    oracle, played = oracle_drop(board, x), drop(board, x=x)
    assert oracle.bin is None
    assert played.bin is None
    assert played.unsettled
    assert played.x_end == pytest.approx(float(oracle.x_end), abs=1e-13)


# States and comparisons.


def test_states_between_events_are_the_oracles() -> None:
    """Compare full states at evenly spaced times, in flight and in contact."""
    board = scene(
        pegs=(Peg(0.0, 0.0, 0.4),),
        friction=0.4,
        drag=0.5,
        restitution=0.3,
        bins=Bins(2.0, (-50.0, 0.0, 50.0), (1.0, 1.0)),
    )
    oracle, played = oracle_drop(board, 0.05), drop(board, x=0.05)
    times = [played.duration * i / 101 for i in range(101)]
    for t, state in zip(times, played.states(times), strict=True):
        truth = oracle.state_at(t)
        for name in ("x", "y", "theta", "vx", "vy", "omega"):
            assert abs(float(getattr(truth, name) - float(state[name]))) < 1e-12, (t, name)
    assert {2, 3, 4} <= set(kinds(oracle))


def test_a_golden_drop_keeps_what_the_comparison_needs() -> None:
    """The comparison notices a wrong bin, a wrong event and a moved ball."""
    name = "triangle-8"
    board = accuracy_boards()[name]
    kept: GoldenDrop = golden.load(name)[1][0]
    impacts = drop(board, x=kept.x).impacts
    moved = impacts.copy()
    moved["x"][2] += 1e-9
    assert max(golden.position_errors(kept, moved, FIRST_IMPACTS)) > WORST
    moved["index"][2] += 1
    assert golden.turns_of(moved).split()[: kept.sharp] != kept.turns.split()[: kept.sharp]
