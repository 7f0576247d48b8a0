"""Which surface owns each point of a board's boundary."""

import math
from itertools import permutations, product

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given

from plinko.engine import Board
from plinko.engine.exact.board_arrays import arrays_of, wall_at
from plinko.engine.exact.surfaces import lay_out
from plinko.engine.physics import surface
from plinko.engine.physics.surface import is_flush
from tools.boards.wall_boards import wall_boards

Items = npt.NDArray[np.float64]
Peg = tuple[float, float, float]
Wall = tuple[float, float, float, float]

RADIUS = 0.05
ULP = 2.0**-52  # of a coordinate from 1 to 2


def laid_out(*walls: Wall, pegs: tuple[Peg, ...] = ()) -> Items:
    items = np.zeros((len(pegs) + 3 * len(walls), surface.COLUMNS))
    lay_out(np.reshape(pegs, (-1, 3)), np.reshape(walls, (-1, 4)), RADIUS, items)
    return items


def owners(items: Items) -> list[int]:
    """The surfaces that own themselves."""
    return np.flatnonzero(items[:, surface.OWNER] == np.arange(len(items))).tolist()


def lines(items: Items) -> list[int]:
    return [item for item in owners(items) if items[item, surface.DISTANCE] == 0.0]


def ends(items: Items, line: int) -> list[int]:
    first, last = items[line, [surface.FIRST_END, surface.LAST_END]]
    return [int(first), int(last)]


def extent(items: Items, line: int) -> list[tuple[float, float]]:
    """The places where a line begins and ends, in order."""
    row = items[line].tolist()
    return sorted([(row[surface.X], row[surface.Y]), (row[surface.END_X], row[surface.END_Y])])


def board(*walls: Wall) -> Board:
    return Board.from_json(
        {
            "ball": {"radius": RADIUS},
            "walls": [dict(zip(("x1", "y1", "x2", "y2"), wall, strict=True)) for wall in walls],
            "bins": {"y": 3.0, "edges": [-1.0, 4.0]},
            "drop": {"x": 0.0},
        }
    )


def turned(wall: Wall) -> Wall:
    return wall[2:] + wall[:2]


def test_a_peg_and_a_single_wall_own_all_their_surfaces() -> None:
    items = laid_out((0.0, 1.0, 3.0, 5.0), pegs=((5.0, 5.0, 0.1),))
    assert owners(items) == [0, 1, 2, 3]
    assert items[0, : surface.LENGTH].tolist() == [5.0, 5.0, RADIUS + 0.1]
    line = items[1]
    assert line[[surface.LENGTH, surface.TX, surface.TY]].tolist() == [5.0, 3.0 / 5.0, 4.0 / 5.0]
    assert line[[surface.NX, surface.NY]].tolist() == [-4.0 / 5.0, 3.0 / 5.0]
    assert ends(items, 1) == [2, 3]


Row = tuple[str, list[Wall], list[Peg], list[int], dict[int, list[int]]]


def gap(width: float) -> Row:
    return f"a gap of {width}", [(0, 1, 1, 1), (1 + width, 1, 2, 1)], [], [*range(6)], {}


def bend(turn: float) -> Row:
    """The two walls share an end."""
    walls: list[Wall] = [(0, 1, 1, 1), (1, 1, 2, 1 + turn)]
    return f"a bend of {turn}", walls, [], [0, 1, 2, 3, 5], {0: [1, 2], 3: [2, 5]}


LEVEL = (0.0, 0.0, 1.0, 0.0)
OWNERS: list[Row] = [
    ("two along one line", [(0, 1, 1, 2), (1, 2, 2, 3)], [], [0, 1, 5], {0: [1, 5]}),
    ("two that overlap", [(0, 1, 2, 2), (1, 1.5, 3, 2.5)], [], [0, 1, 5], {0: [1, 5]}),
    ("one within another", [(0, 1, 4, 3), (1, 1.5, 2, 2)], [], [0, 1, 2], {0: [1, 2]}),
    ("one around another", [(1, 1.5, 2, 2), (0, 1, 4, 3)], [], [0, 4, 5], {0: [4, 5]}),
    ("a bridge", [(0, 1, 1, 1), (3, 1, 4, 1), (1, 1, 3, 1)], [], [0, 1, 5], {0: [1, 5]}),
    *map(gap, (1e-9, 1e-12)),
    ("parallel", [(0, 1, 2, 1), (0, 1 + 1e-9, 2, 1 + 1e-9)], [], [*range(6)], {}),
    *map(bend, (1e-9, 1e-3, 1.0, -1.0)),
    ("an end on a wall", [(-1, 1, 1, 1), (0.25, 1, 0.25, 0)], [], [0, 1, 2, 3, 5], {}),
    ("an end near a wall", [(-1, 1, 1, 1), (0.25, 1 - 1e-9, 0.25, 0)], [], [*range(6)], {}),
    (
        "an end on a joint within a straight wall",
        [(-1, 1, 0, 1), (0, 1, 1, 1), (0, 1, 0, 0)],
        [],
        [0, 1, 5, 6, 8],
        {},
    ),
    # The line crosses the peg's circle, and does not continue it.
    ("an end within a peg", [LEVEL], [(0.05, 0.02, 0.1)], [0, 1, 3], {1: [2, 3]}),
    ("an end beside a peg", [LEVEL], [(-0.1 - 1e-9, 0.0, 0.1)], [0, 1, 2, 3], {1: [2, 3]}),
    ("a peg lower than a wall", [LEVEL], [(0.01, -0.1 + 1e-9, 0.1)], [0, 1, 2, 3], {1: [2, 3]}),
]


@pytest.mark.parametrize(
    ("walls", "pegs", "owned", "line_ends"), [pytest.param(*row, id=name) for name, *row in OWNERS]
)
def test_pieces_of_one_straight_wall_are_one_and_others_are_not(
    walls: list[Wall], pegs: list[Peg], owned: list[int], line_ends: dict[int, list[int]]
) -> None:
    """A line goes from the outermost of its pieces' ends; items are pegs, then each wall's line and
    ends."""
    items = laid_out(*walls, pegs=tuple(pegs))
    assert owners(items) == owned
    for line, found in line_ends.items():
        assert ends(items, line) == found
    if lines(items) == [0]:
        places = {place for wall in walls for place in (wall[:2], wall[2:])}
        assert extent(items, 0) == [min(places), max(places)]


THIRDS: list[Wall] = [(0.0, 1.0, 1.0, 1.5), (1.0, 1.5, 2.0, 2.0), (2.0, 2.0, 3.0, 2.5)]


@pytest.mark.parametrize("order", list(permutations(range(3))))
def test_three_pieces_in_any_order_and_direction_are_one_wall(order: tuple[int, ...]) -> None:
    for ways in product([False, True], repeat=3):
        parts = [turned(THIRDS[i]) if ways[i] else THIRDS[i] for i in order]
        items = laid_out(*parts)
        assert lines(items) == [0]
        assert extent(items, 0) == [(0.0, 1.0), (3.0, 2.5)]
        assert len(owners(items)) == 3  # the line and its two outermost ends
        for end, place in zip(ends(items, 0), (0, 2), strict=True):
            at = items[0, [surface.X, surface.Y] if place == 0 else [surface.END_X, surface.END_Y]]
            assert items[end, : surface.DISTANCE].tolist() == at.tolist()
        assert items[0, surface.TX] * (-1.0 if ways[order[0]] else 1.0) > 0.0  # the first's way


def test_equal_walls_are_one_in_either_direction() -> None:
    wall = (0.1, 1.0, 0.7, 1.3)
    for other in (wall, turned(wall)):
        items = laid_out(wall, other)
        assert owners(items) == [0, 1, 2]
        assert (
            items[0, : surface.FIRST_END].tolist()
            == laid_out(wall)[0, : surface.FIRST_END].tolist()
        )


@pytest.mark.parametrize("off", [-1, 0, 1])
@pytest.mark.parametrize("along", [-1, 0, 1])
def test_walls_that_coincide_within_an_ulp_are_one(off: int, along: int) -> None:
    shifted = (0.0, 1.5 + off * ULP, 1.5 + along * ULP, 1.5 + off * ULP)
    assert lines(laid_out((0.0, 1.5, 1.5, 1.5), shifted)) == [0]
    next_one = (1.5 + along * ULP, 1.5 + off * ULP, 2.5, 1.5)
    assert lines(laid_out((0.0, 1.5, 1.5, 1.5), next_one)) == [0]


def test_walls_in_a_fan_all_share_the_first_one_s_end() -> None:
    items = laid_out(*((0.0, 0.0, math.cos(a), math.sin(a)) for a in (0.0, 1.0, 2.0, 3.0)))
    assert [ends(items, line)[0] for line in lines(items)] == [1, 1, 1, 1]


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_wall_flush_with_a_peg_continues_as_the_peg_s_circle(side: float) -> None:
    peg = (0.0, side * -0.1, 0.1)  # its highest point is the wall's end
    items = laid_out((0.0, 0.0, 1.0, 0.0), pegs=(peg,))
    assert owners(items) == [0, 1, 3]
    assert ends(items, 1) == [0, 3]
    assert is_flush(items, RADIUS, 1, side, 0)
    assert not is_flush(items, RADIUS, 1, -side, 0)


def test_a_wall_is_flush_with_its_own_ends_on_both_sides() -> None:
    items = laid_out((0.3, 1.1, 1.7, 2.9))
    assert all(is_flush(items, RADIUS, 0, side, end) for side in (-1.0, 1.0) for end in (1, 2))


def test_a_ball_on_a_joined_wall_touches_the_lowest_piece_at_its_foot() -> None:
    middle, right, left = (1.0, 1.5, 2.0, 2.0), (2.0, 2.0, 3.0, 2.5), (1.2, 1.6, 0.0, 1.0)
    sides = (-1.0, -1.0, -1.0, 3.0), (4.0, -1.0, 4.0, 3.0)
    arrays = arrays_of(board(middle, right, left, *sides))
    places = {0.1: 2, 0.9: 2, 1.1: 0, 1.9: 0, 2.0: 0, 2.1: 1, 3.0: 1, -0.01: 2, 3.01: 1}
    assert {x: wall_at(arrays, 0, x, 1.0 + 0.5 * x) for x in places} == places
    first, last = ends(arrays.items, 0)
    assert [wall_at(arrays, first, 0.0, 1.0), wall_at(arrays, last, 3.0, 2.5)] == [2, 1]


@given(wall_boards)
def test_the_layout_of_a_board_is_consistent(board: Board) -> None:
    """Owners own themselves; a line's ends are circles at its ends or flush with it; each wall is a
    piece of one line, whose pieces cover it."""
    arrays = arrays_of(board)
    items, pegs = arrays.items, len(board.pegs)
    owner = items[:, surface.OWNER].astype(int)
    assert (owner[:pegs] == np.arange(pegs)).all()
    listed: list[int] = []
    for line in lines(items):
        pieces = [line]
        while items[pieces[-1], surface.NEXT] >= 0:
            pieces.append(int(items[pieces[-1], surface.NEXT]))
        assert (owner[pieces] == line).all()
        assert pieces == sorted(pieces)
        listed += pieces
        begun, done = items[pieces, surface.FROM], items[pieces, surface.TO]
        near = 1e-14 * (1.0 + np.abs(items[line, [surface.X, surface.Y]]).sum())
        assert abs(begun.min()) <= near
        assert abs(done.max() - items[line, surface.LENGTH]) <= near
        spans = sorted(zip(begun.tolist(), done.tolist(), strict=True))
        covered = 0.0
        for low, high in spans:
            assert low <= covered + near
            covered = max(covered, high)
        for end in ends(items, line):
            if end >= pegs:
                x, y = items[end, [surface.X, surface.Y]]
                both = [(surface.X, surface.Y), (surface.END_X, surface.END_Y)]
                gaps = [abs(items[line, i] - x) + abs(items[line, j] - y) for i, j in both]
                assert min(gaps) <= surface.rounding(x, y)
            else:
                assert any(is_flush(items, board.ball.radius, line, way, end) for way in (-1, 1))
    assert sorted(listed) == list(range(pegs, len(items), 3))
