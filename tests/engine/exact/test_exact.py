"""The exact solver conserves energy, never passes through a surface, and ends endless motions."""

import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchmarks.scenes.contact_scenes import scene, scene_names
from plinko.engine import Board, drop
from plinko.engine.board.parts import Bins, DropZone, Peg, Wall
from plinko.engine.constants import (
    KIND_CONTACT_BEGIN,
    KIND_CONTACT_CHANGE,
    KIND_CONTACT_END,
    KIND_LANDING,
    KIND_WALL,
)
from plinko.engine.drops.trajectory import Trajectory, at_start, follow
from plinko.engine.exact import event_log
from plinko.engine.exact.board_arrays import arrays_of
from plinko.engine.exact.event_log import new_log
from plinko.engine.exact.outcome import (
    BALANCED,
    ESCAPED,
    EVENT_LIMIT,
    MAX_EVENTS,
    REASONS,
    SEARCH_LIMIT,
    WEDGED,
)
from plinko.engine.parameters import Exact, SolverName, Stepped
from plinko.engine.physics import body
from tests.engine.exact.one_ball import trace
from tests.engine.multibody.static_scenes import any_board, box, mirrored, place
from tests.long import tries
from tools.oracle.scenes import scene as open_scene

Floats = npt.NDArray[np.float64]

G = 9.81
SOLVERS = pytest.mark.parametrize("solver", [Exact(), Stepped()], ids=["exact", "stepped"])
NEAR = 1e-12
"""Largest overlap with a surface that rounding may cause, m."""


def board_of(name: str) -> Board:
    return scene(name).board if name in scene_names() else Board.preset(name)


def overlap(board: Board, x: Floats, y: Floats) -> float:
    """Deepest overlap in m of a ball at any of the places with any surface."""
    least = math.inf
    for p in board.pegs:
        least = min(least, float((np.hypot(x - p.x, y - p.y) - p.radius).min()))
    for w in board.walls:
        tx, ty = w.x2 - w.x1, w.y2 - w.y1
        along = np.clip(((x - w.x1) * tx + (y - w.y1) * ty) / (tx * tx + ty * ty), 0.0, 1.0)
        gap = np.hypot(x - w.x1 - along * tx, y - w.y1 - along * ty)
        least = min(least, float(gap.min()))
    return board.ball.radius - least


def energies(path: Trajectory, events: Floats) -> Floats:
    """Energy per mass in J/kg at events (t, x, y, vx, vy, omega), zero at the bins' line."""
    spin = 0.25 * (path.board.ball.radius * events[:, 5]) ** 2
    motion = 0.5 * (events[:, 3] ** 2 + events[:, 4] ** 2)
    energy: Floats = motion + spin + path.board.gravity * (path.board.bins.y - events[:, 2])
    return energy


def test_energy_is_kept_over_a_hundred_thousand_elastic_impacts() -> None:
    pegs = tuple(Peg(0.2 * i - 0.4, 0.15 + 0.2 * j, 0.03) for i in range(5) for j in range(5))
    board = box(1.0, 1.1, pegs=pegs, restitution=1.0, radius=0.02)
    state = np.array([0.0, 0.1, 0.06, 2.0, 1.0, 0.0, 0.0])
    start = 0.5 * (2.0**2 + 1.0**2) + G * (1.1 - 0.06)
    log = new_log(100_000, 0)
    outcome, _ = trace(arrays_of(board), state, 100_000, 1e9, log)
    assert outcome == EVENT_LIMIT
    x, y, vx, vy = log.events[:, 1:5].T
    energy = 0.5 * (vx * vx + vy * vy) + G * (1.1 - y)
    assert abs(energy / start - 1.0).max() <= 1e-12
    assert overlap(board, x, y) <= NEAR
    assert (
        len(np.unique(log.marks[:, 0] * 100 + log.marks[:, 1])) == 25 + 4
    )  # it has hit every surface


@pytest.mark.parametrize("name", ["triangle-8", "triangle-16", "classic", *scene_names()])
def test_a_ball_is_never_inside_anything_and_gains_no_energy(name: str) -> None:
    board = board_of(name)
    for seed in range(5):
        found = drop(board, seed)
        states = found.states(np.linspace(0.0, found.duration, 3000))
        assert overlap(board, states["x"], states["y"]) <= NEAR
        path = found.trajectory
        assert (np.diff(path.events[:, 0]) >= 0.0).all(), "time runs forward"
        start = board.gravity * (board.bins.y - board.drop.y)
        energy = np.concatenate([[start], energies(path, path.events)])
        assert (np.diff(energy) <= 1e-12 * start).all()


@SOLVERS
@pytest.mark.parametrize("name", ["triangle-8", "triangle-16", "galton", *scene_names()])
def test_a_mirrored_start_on_a_mirrored_board_mirrors_the_path(
    name: str, solver: Exact | Stepped
) -> None:
    """To the last bit: x, vx and omega are negated, the bin is mirrored, the rest is equal."""
    board = board_of(name)
    flip = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    for seed in range(8 if solver == Exact() else 3):
        x = drop(board, seed).x_start
        path = follow(board, at_start(board, x), solver)
        image = follow(mirrored(board), at_start(board, -x), solver)
        assert np.array_equal(path.events, image.events * flip)
        landings = path.marks[:, 0] == KIND_LANDING
        assert np.array_equal(path.marks[~landings], image.marks[~landings])
        assert image.outcome == path.outcome
        if path.bin >= 0:
            assert image.bin == board.bins.count - 1 - path.bin


def test_every_preset_is_its_own_mirror_image() -> None:
    """Mirroring reorders the pegs, so this shows that a path does not depend on their order."""
    for name in ("triangle-9", "triangle-16", "classic", "galton"):
        board = Board.preset(name)
        for seed in range(8):
            x = drop(board, seed).x_start
            here, there = drop(board, x=x), drop(board, x=-x)
            assert there.bin == board.bins.count - 1 - (here.bin or 0)
            for field, sign in (("t", 1.0), ("x", -1.0), ("y", 1.0), ("omega", -1.0)):
                assert np.array_equal(here.impacts[field], sign * there.impacts[field])


@pytest.mark.parametrize("gravity", [1.62, 3.72, 24.79])
def test_another_world_is_the_same_but_slower_or_faster(gravity: float) -> None:
    """Without drag, times are proportional to 1 / sqrt(g); the path does not depend on g."""
    pegs = (Peg(0.0, 0.0, 0.2), Peg(0.9, 0.6, 0.3), Peg(-0.6, 0.8, 0.3))
    here, there = (
        drop(open_scene(pegs=pegs, restitution=0.6, friction=0.2, gravity=g), x=0.05)
        for g in (G, gravity)
    )
    assert here.bin == there.bin
    assert there.impacts["x"] == pytest.approx(here.impacts["x"], abs=1e-11)
    pace = math.sqrt(G / gravity)
    assert there.impacts["t"] == pytest.approx(here.impacts["t"] * pace, rel=1e-12)


def test_a_ball_in_the_open_falls_by_the_closed_form() -> None:
    zone = DropZone(0.3, -1.0, 0.0)
    fall = drop(place(bins=Bins(3.0, (-1.0, 0.0, 1.0), (1.0, 2.0)), drop=zone), x=0.3)
    assert fall.duration == pytest.approx(math.sqrt(8.0 / G), rel=1e-15)
    assert (fall.bin, fall.score, fall.x_end) == (1, 2.0, 0.3)
    slow = drop(place(bins=Bins(3.0, (-1.0, 0.0, 1.0), (1.0, 2.0)), drop=zone, drag=2.0), x=0.3)
    t = slow.duration
    assert G / 2.0 * t - G / 4.0 * -math.expm1(-2.0 * t) == pytest.approx(4.0, rel=1e-14)


@pytest.mark.parametrize("e", [0.2, 0.5, 0.9])
def test_a_bouncing_ball_rests_after_the_geometric_series(e: float) -> None:
    """Infinitely many bounces take a finite time: t0 (1 + e) / (1 - e) if the fall takes t0."""
    board = place(walls=(Wall(-1.0, 1.0, 1.0, 1.0),), restitution=e)
    rest = drop(board, x=0.0)
    fall = math.sqrt(2.0 * (1.0 - board.ball.radius) / G)
    assert rest.duration == pytest.approx(fall * (1.0 + e) / (1.0 - e), rel=1e-7)
    assert rest.unsettled == "balanced: at rest on a surface"
    bounces = rest.impacts[rest.impacts["kind"] == KIND_WALL]
    speeds = -bounces["vy"]
    assert np.allclose(speeds[1:] / speeds[:-1], e, rtol=1e-6)
    assert rest.impacts["kind"][-1] == KIND_CONTACT_BEGIN


def test_a_ball_hits_a_wall_s_end_as_a_disc_of_its_own_radius() -> None:
    """A ball that falls on the end of an upright wall touches it on a circle around the end."""
    board = place(walls=(Wall(0.0, 1.0, 0.0, 2.0),), restitution=1.0)
    for x in (1e-9, 0.03, -0.07, 0.0999, -0.1 + 1e-9):
        hit = follow(board, at_start(board, x), Exact()).events[0]
        depth = math.sqrt((0.1 - abs(x)) * (0.1 + abs(x)))
        assert hit[2] == pytest.approx(1.0 - depth, abs=1e-15 + 1e-17 / max(depth, 1e-9))
        down = math.sqrt(2.0 * G * hit[2])
        nx, ny = x / 0.1, -depth / 0.1
        assert hit[3] == pytest.approx(-2.0 * down * ny * nx, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("miss", [1e-12, 1e-9, 1e-6])
def test_a_ball_that_passes_an_end_by_a_hair_is_not_touched(miss: float) -> None:
    board = place(walls=(Wall(0.0, 1.0, 0.0, 2.0),), bins=Bins(3.0, (-1.0, 0.0, 1.0), (1.0, 1.0)))
    assert len(follow(board, at_start(board, 0.1 + miss), Exact()).events) == 1  # only the landing
    assert len(follow(board, at_start(board, 0.1 - miss), Exact()).events) > 1


@pytest.mark.parametrize("solver", ["exact", "stepped"])
@pytest.mark.parametrize("name", ["apex", "shelf"])
def test_a_ball_exactly_above_its_support_comes_to_rest_on_it(
    name: str, solver: SolverName
) -> None:
    rest = drop(scene(name).board, x=0.0, solver=solver)
    assert (rest.bin, rest.score) == (None, 1.0)
    assert rest.unsettled == "balanced: at rest on a surface"
    assert len(rest.impacts) < 100
    assert rest.duration < 2.0
    assert rest.x_end == 0.0
    later = rest.states([rest.duration, rest.duration + 100.0])
    assert later["y"][0] == later["y"][1]
    assert later["vy"][0] == 0.0


def test_a_ball_a_breath_off_the_top_of_a_peg_leaves_it() -> None:
    board = scene("apex").board
    for offset in (1e-15, -1e-12, 1e-6):
        off = drop(board, x=offset)
        assert off.bin is not None
        assert (off.x_end > 0.0) is (offset > 0.0)


@SOLVERS
@pytest.mark.parametrize("drag", [0.5, 2.0])
def test_rolling_on_level_ground_is_stopped_by_drag_and_ends(
    drag: float, solver: Exact | Stepped
) -> None:
    """Drag never stops the ball, but its drop ends when the way left is below rounding."""
    walls = (Wall(-50.0, 1.0, 50.0, 1.0), Wall(-0.5, 0.2, 0.0, 0.5))
    for friction in (0.0, 0.5):
        board = place(walls=walls, restitution=0.3, friction=friction, drag=drag)
        rest = follow(board, at_start(board, -0.25), solver)
        assert rest.outcome == BALANCED
        assert rest.end[0] < 90.0 / drag


V_NOTCH = (Wall(-1.0, 0.2, 0.0, 1.0), Wall(0.0, 1.0, 1.0, 0.2))


@pytest.mark.parametrize("e", [0.0, 0.5, 0.7])
@pytest.mark.parametrize("friction", [0.0, 0.1])
@pytest.mark.parametrize("drag", [0.0, 2.0])
def test_a_ball_in_a_notch_wedges(e: float, friction: float, drag: float) -> None:
    """Between walls or pegs, the drop soon ends at rest, with a reason, and returns the stake."""
    pegs = (Peg(-0.13, 1.0, 0.1), Peg(0.13, 1.0, 0.1))
    funnel = (Wall(-0.5, 0.3, -0.2, 0.9), Wall(0.5, 0.3, 0.2, 0.9))
    for parts in ({"walls": V_NOTCH}, {"pegs": pegs, "walls": funnel}):
        board = place(**parts, restitution=e, friction=friction, drag=drag)
        stuck = drop(board, x=0.0)
        slid = follow(board, at_start(board, 0.03), Exact())
        assert (stuck.bin, stuck.score) == (None, 1.0)
        assert stuck.unsettled == REASONS[WEDGED]
        assert stuck.duration < 30.0
        assert len(stuck.impacts) <= 2000
        assert slid.outcome == WEDGED
        assert slid.end[0] < 60.0


def test_a_ball_that_bounces_for_ever_ends_by_time_or_by_events() -> None:
    board = place(walls=(Wall(-1.0, 1.0, 1.0, 1.0),), restitution=1.0)
    for_ever = drop(board, x=0.0)
    assert for_ever.unsettled == "time budget: still moving after 1,000 s"
    assert 998.0 < for_ever.duration < 1002.0
    assert (for_ever.bin, for_ever.score) == (None, 1.0)
    start = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    counted = follow(board, start, Exact(), max_events=50)
    assert counted.outcome == EVENT_LIMIT
    assert len(counted.events) == 50


def test_a_drop_is_the_same_after_one_that_ran_out_of_events() -> None:
    """Both drops use the same memory, which still has the first drop's unfinished state."""
    board = place(walls=(Wall(-1.0, 1.0, 1.0, 1.0),), restitution=1.0)
    start, close = at_start(board, 0.0), at_start(board, 0.0)
    close[body.Y] = 1.0 - board.ball.radius - 1e-6
    before = follow(board, start, Exact())
    assert follow(board, close, Exact()).outcome == EVENT_LIMIT
    after = follow(board, start, Exact())
    assert after.events.tobytes() == before.events.tobytes()
    assert after.outcome == before.outcome


def test_a_ball_thrown_off_the_board_escapes_or_runs_out_of_time() -> None:
    far = np.array([0.0, 1e12, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert follow(place(), far, Exact()).outcome == ESCAPED
    fast = np.array([0.0, 0.0, 0.0, 1e8, -1e8, 0.0, 0.0])
    assert follow(place(), fast, Exact()).outcome == SEARCH_LIMIT


def test_a_contact_phase_is_told_from_its_beginning_to_its_end() -> None:
    """Contacts begin and end in turn, changes lie in between, and the ball stays on the surface."""
    seen = 0
    for name in ("low-restitution", "dead", "zigzag", "polyline", "ramp"):
        for seed in range(6):
            kinds = drop(scene(name).board, seed).impacts["kind"].tolist()
            riding = False
            for kind in kinds:
                if kind == KIND_CONTACT_BEGIN:
                    assert not riding
                    riding = True
                    seen += 1
                elif kind == KIND_CONTACT_CHANGE:
                    assert riding
                elif kind == KIND_CONTACT_END:
                    assert riding
                    riding = False
                elif riding:  # hit something, or landed, while riding
                    riding = False
    assert seen > 60


@given(any_board, st.floats(-0.9, 0.9))
@settings(suppress_health_check=[HealthCheck.too_slow], max_examples=tries(50, 500))
def test_on_any_board_a_ball_ends_and_is_never_inside_anything(board: Board, x: float) -> None:
    path = follow(board, at_start(board, x), Exact())
    assert path.outcome != ESCAPED
    assert len(path.events) <= MAX_EVENTS + 1
    assert (np.diff(path.events[:, 0]) >= 0.0).all()
    few = path.events[:2000]
    start = board.gravity * (board.bins.y + 0.5)
    assert energies(path, few).max(initial=0.0) <= start * (1.0 + 1e-12)
    assert overlap(board, few[:, 1], few[:, 2]) <= NEAR
    states = path.states_at(np.linspace(0.0, min(path.end[0], 20.0), 1000))
    assert overlap(board, states[:, 1], states[:, 2]) <= NEAR


def test_logs_that_are_too_small_count_what_did_not_fit() -> None:
    board = Board.preset("triangle-16")
    full = drop(board, 42).trajectory
    state, log = full.start.copy(), new_log(3, 2)
    trace(arrays_of(board), state, MAX_EVENTS, 1000.0, log)
    assert int(log.counts[event_log.EVENTS]) == len(full.events)
    assert np.array_equal(log.events, full.events[:3])
    assert np.array_equal(state, full.end)
