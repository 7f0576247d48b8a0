"""Proofs on walls in pieces: the surface of a board does not depend on how its walls are cut."""

from collections.abc import Callable
from itertools import pairwise

import pytest

from plinko.engine import Board, ParameterError, certify, drop
from plinko.engine.board.parts import Bins, Peg, Wall
from plinko.engine.certified.certify import Certificate, Effort
from tests.long import many, tries
from tools.boards.wall_boards import seeds_of, wall_board, wall_pair
from tools.oracle.scenes import scene

QUICK = Effort(160, 1280, 20_000)
RAMP = Wall(-2.0, 1.0, 2.0, 3.0)
X = -1.4856294682631606


def marks(found: Certificate) -> list[tuple[int, int]]:
    assert found.path is not None
    return [(event.kind, event.index) for event in found.path.events]


def slope(*walls: Wall) -> Board:
    """The ramp of these walls, plastic and rough."""
    return scene(walls=walls, radius=0.125, friction=0.3, bins=Bins(8.0, (-50.0, 50.0), (1.0,)))


@pytest.mark.parametrize("cuts", [(0.0,), (-1.5, 1.0), (-1.75, -1.25, 0.5)])
def test_a_straight_wall_in_pieces_is_proven_as_one_wall(cuts: tuple[float, ...]) -> None:
    ends = [-2.0, *cuts, 2.0]
    pieces = [Wall(a, 2.0 + a / 2.0, b, 2.0 + b / 2.0) for a, b in pairwise(ends)]
    one, cut = (certify(slope(*walls), x=X, effort=QUICK) for walls in ([RAMP], pieces))
    assert one.decided
    assert (one.x_end, one.duration) == (cut.x_end, cut.duration)
    assert [kind for kind, _ in marks(one)] == [kind for kind, _ in marks(cut)]
    doubles = drop(slope(*pieces), x=X).impacts
    assert marks(cut) == [(int(row["kind"]), int(row["index"])) for row in doubles]


def test_a_wall_continues_as_a_peg_with_which_it_is_flush() -> None:
    """A level wall, tangent to a peg's top at its end: the ball rolls from one onto the other."""
    board = scene(
        walls=(Wall(-1.0, 0.0, 0.0, 0.0), Wall(-2.0, -1.0, -1.0, 0.0)),
        pegs=(Peg(0.0, 0.25, 0.25),),
        radius=0.125,
        friction=1.0,
    )
    found = certify(board, x=-1.5, effort=QUICK)
    assert found.decided
    doubles = drop(board, x=-1.5).impacts
    assert marks(found) == [(int(row["kind"]), int(row["index"])) for row in doubles]
    assert (3, 0) in marks(found)


def test_a_peg_under_a_wall_is_passed_without_an_impact() -> None:
    peg = Peg(0.0, 0.25, 0.25)
    walls = Wall(-1.0, 0.0, 1.0, 0.0), Wall(-2.0, -1.0, -1.0, 0.0)
    plain, flush = (
        certify(scene(walls=walls, pegs=pegs, radius=0.125, friction=1.0), x=-1.5, effort=QUICK)
        for pegs in ((), (peg,))
    )
    assert plain.decided
    assert (plain.x_end, marks(plain)) == (flush.x_end, marks(flush))


def test_a_ball_that_bounces_along_a_wall_passes_the_joint_of_another_in_line() -> None:
    """Between the two walls is a gap of a tenth of a micrometre: they are not one wall."""
    walls = Wall(0.5, -2.0, 0.5, 1.5), Wall(0.5, 1.5000001, 0.5, 3.0), Wall(-0.5, -0.2, 0.0, 0.3)
    board = scene(walls=walls, radius=0.125, restitution=0.25)
    found = certify(board, x=-0.25, effort=QUICK)
    assert found.decided
    assert found.agrees
    assert (1, 0) in marks(found)


@pytest.mark.long
def test_a_ball_crawls_down_a_wall_through_treacle() -> None:
    """Strong drag makes the motion forget its errors; a proof must not let them grow."""
    board = scene(
        walls=(Wall(-1.0, 0.0, 1.0, 0.3),),
        radius=0.125,
        friction=0.5,
        drag=100.0,
        bins=Bins(0.1, (-50.0, 0.0, 50.0), (1.0, 1.0)),
    )
    found = certify(board, x=-0.5, effort=Effort(160, 320, 100_000))
    assert found.bin == drop(board, x=-0.5).bin
    assert found.x_end is not None
    assert found.x_end.high - found.x_end.low < 1e-9


@pytest.mark.parametrize("number", [many(20003), 20008, 20036, 20047, many(20059), 20083])
def test_a_ball_passes_joints_of_walls_that_are_in_line_within_rounding(number: int) -> None:
    """It comes to the next wall's end inside that end, by less than its coordinates' rounding."""
    board = wall_board(number)
    for seed in seeds_of(number, 2):
        found = certify(board, seed, effort=QUICK)
        assert found.decided, found.undecided
        assert found.agrees


@pytest.mark.parametrize(
    "numbers", [range(12), pytest.param(range(12, tries(22, 500)), marks=pytest.mark.long)]
)
def test_on_walls_in_pieces_proofs_and_certain_bins_agree(numbers: range) -> None:
    decided = 0
    for number in numbers:
        board = wall_board(number)
        for seed in seeds_of(number, 1):
            found, made = certify(board, seed, effort=QUICK), drop(board, seed)
            if found.decided:
                decided += 1
                assert found.bin == made.bin or not made.certain, (number, seed)
    assert decided > 0.9 * len(numbers)


def test_proofs_on_a_whole_wall_and_on_its_pieces_agree() -> None:
    """The joints of even boards are exactly on the wall: the proven digits are the same."""
    for number in range(0, 2 * tries(5, 100), 2):
        whole, cut = wall_pair(number)
        for seed in seeds_of(number, 1):
            one, two = (certify(board, seed, effort=QUICK) for board in (whole, cut))
            assert (one.bin, one.unsettled) == (two.bin, two.unsettled), (number, seed)
            assert (one.x_end, one.duration) == (two.x_end, two.duration), (number, seed)


def ticking() -> Callable[[], float]:
    """A clock that goes on by a second at each look."""
    looks = iter(range(10**9))
    return lambda: float(next(looks))


def test_a_series_of_thousands_of_terms_ends_when_the_time_is_over() -> None:
    """A ball that stays on a slope, with so many bits that one series takes seconds."""
    clock = ticking()
    found = certify(slope(RAMP), x=X, effort=Effort(first_bits=5120, seconds=50.0, clock=clock))
    assert found.undecided is not None
    assert found.comparisons < 50
    assert clock() < 60.0


def test_a_proof_in_python_has_a_limit_of_time() -> None:
    board = Board.preset("triangle-8")
    found = certify(board, 42, seconds=50.0, clock=ticking())
    assert found.undecided is not None
    assert found.undecided.endswith(": undecided after 50 s, at 160 bits")
    assert found.comparisons == 50
    assert certify(board, 42, seconds=1e6, clock=ticking()).decided
    with pytest.raises(ParameterError, match=r"seconds 8.0 need a clock"):
        certify(board, 42, seconds=8.0)
    with pytest.raises(ParameterError, match="seconds -1 is not a positive number"):
        certify(board, 42, seconds=-1, clock=ticking())
    with pytest.raises(ParameterError, match="seconds None is not a positive number"):
        certify(board, 42, clock=ticking())
