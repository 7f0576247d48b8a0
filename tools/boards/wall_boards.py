"""Numbered random boards whose walls come in pieces.

`wall_board(n)` is board number n, the same on every machine and one that the validator accepts.
Its walls are cut, joined, doubled, crossed and tangent to pegs: places where the surface of the
board is easily taken for that of a single wall. `python -m tools.boards.wall_boards FIRST COUNT
DROPS` checks DROPS drops on each of COUNT boards by `tools.boards.checked_drops` and prints the
failures; with `--pairs`, it compares drops on walls that are whole on one board and cut on another.
"""

import argparse
import math
import sys
import time
from collections import Counter
from itertools import pairwise
from random import Random
from typing import Any, Final

from hypothesis import strategies as st

from plinko.engine.board.model import Board
from plinko.engine.errors import BoardError
from tools.boards.checked_drops import Failure, check_drops, compare_drops
from tools.boards.hard_boards import (
    BOTTOM,
    SIDE,
    Draft,
    Recipe,
    chute,
    corner_of_walls,
    funnel,
    notch_of_pegs,
    overhangs,
    peg_on_a_wall,
    shelves,
)

RADII: Final = (0.02, 0.03, 0.05, 0.05, 0.08, 0.12)
RESTITUTIONS: Final = (0.0, 0.0, 0.0, 0.05, 0.05, 0.1, 0.2, 0.2, 0.3, 0.5, 0.7, 0.9, 1.0)
FRICTIONS: Final = (0.0, 0.0, 0.1, 0.3, 0.5, 1.0, 2.0)
DRAGS: Final = (0.0, 0.0, 0.0, 0.0, 0.01, 0.5, 2.0, 10.0, 100.0)
SLIPS: Final = (0.0, 0.0, 0.0, 1e-15, 1e-12, 1e-9, -1e-12, -1e-9)
"""m; what is left between two pieces of a wall, negative for an overlap."""

Segment = tuple[float, float, float, float]


def cut(choice: Random, wall: Segment, pieces: int, slip: float = 0.0) -> list[Segment]:
    """The wall in pieces of random lengths and directions, with gaps of `slip` m."""
    x1, y1, x2, y2 = wall
    length = math.hypot(x2 - x1, y2 - y1)
    if choice.random() < 0.3:
        shares = [i / pieces for i in range(pieces + 1)]
    else:
        shares = [0.0, *sorted(choice.uniform(0.02, 0.98) for _ in range(pieces - 1)), 1.0]
    parts: list[Segment] = []
    for low, high in pairwise(shares):
        ends = [(x1, y1) if low == 0.0 else _between(wall, low + slip / length)]
        ends.append((x2, y2) if high == 1.0 else _between(wall, high))
        if choice.random() < 0.2:
            ends.reverse()
        if ends[0] != ends[1]:
            parts.append((*ends[0], *ends[1]))
    if choice.random() < 0.2:
        choice.shuffle(parts)
    return parts


def _between(wall: Segment, share: float) -> tuple[float, float]:
    x1, y1, x2, y2 = wall
    return x1 + share * (x2 - x1), y1 + share * (y2 - y1)


def _add_path(draft: Draft, points: list[tuple[float, float]]) -> None:
    for (x1, y1), (x2, y2) in pairwise(points):
        draft.walls.append((x1, y1, x2, y2))


def _slope(draft: Draft, x: float, y: float) -> Segment:
    """A slope through (x, y), from its higher to its lower end."""
    low = math.asin(min(0.9, max(draft.least_slope, 0.01)))
    angle = draft.angle(low, 1.4)
    side = draft.choice.choice([-1.0, 1.0])
    tx, ty = side * math.cos(angle), math.sin(angle)
    up, down = draft.choice.uniform(0.05, 0.6), draft.choice.uniform(0.05, 0.6)
    return x - up * tx, y - up * ty, x + down * tx, y + down * ty


def ramp(draft: Draft, x: float, y: float) -> None:
    """A straight slope in one to seven pieces."""
    slip = draft.choice.choice(SLIPS)
    draft.walls += cut(draft.choice, _slope(draft, x, y), draft.choice.randint(1, 7), slip)


def bend(draft: Draft, x: float, y: float) -> None:
    """A chain of pieces that turns the same way at each joint: a hill or a bowl, or hardly."""
    pieces = draft.choice.randint(2, 9)
    turn = draft.choice.choice([-1.0, 1.0]) * 10.0 ** draft.choice.uniform(-9.0, -0.2)
    _chain(draft, x, y, [turn * draft.choice.uniform(0.5, 1.0) for _ in range(pieces)])


def zigzag(draft: Draft, x: float, y: float) -> None:
    """A chain of pieces that turns any way at each joint."""
    pieces = draft.choice.randint(2, 7)
    _chain(draft, x, y, [draft.choice.uniform(-0.9, 0.9) for _ in range(pieces)])


def _chain(draft: Draft, x: float, y: float, turns: list[float]) -> None:
    side = draft.choice.choice([-1.0, 1.0])
    heading = draft.choice.uniform(0.05, 0.8) - min(0.0, sum(turns)) * draft.choice.random()
    points = [(x - side * draft.choice.uniform(0.1, 0.5), y - 0.2)]
    for turn in turns:
        length = draft.choice.choice([0.3, 0.1, 2.0, 5.0]) * draft.choice.uniform(0.5, 1.5)
        length = length * draft.radius if length > 1.0 else length
        at = points[-1]
        points.append(
            (at[0] + side * length * math.cos(heading), at[1] + length * math.sin(heading))
        )
        heading += turn
    if draft.choice.random() < 0.3:
        points.reverse()
    _add_path(draft, points)


def polygon(draft: Draft, x: float, y: float) -> None:
    """A closed chain around (x, y): regular or not, often smaller than the ball."""
    corners = draft.choice.randint(3, 7)
    phase, size = draft.choice.uniform(0.0, 6.3), draft.choice.choice([0.02, 0.05, 0.1, 0.25])
    regular = draft.choice.random() < 0.4
    angles = sorted(
        phase + 2.0 * math.pi * (i + (0.0 if regular else draft.choice.uniform(0.0, 0.8))) / corners
        for i in range(corners)
    )
    points = [(x + size * math.cos(a), y + size * math.sin(a)) for a in angles]
    _add_path(draft, [*points, points[0]])


def tangent_peg(draft: Draft, x: float, y: float) -> None:
    """A slope and a peg that touches its line, or sits in it or on its end."""
    wall = _slope(draft, x, y)
    x1, y1, x2, y2 = wall
    length = math.hypot(x2 - x1, y2 - y1)
    nx, ny = (y1 - y2) / length, (x2 - x1) / length
    radius = draft.choice.choice([0.005, 0.02, draft.radius, 0.1])
    px, py = _between(wall, draft.choice.choice([0.0, 1.0, 0.5, draft.choice.random()]))
    slip = draft.choice.choice(SLIPS)
    off = draft.choice.choice([0.0, radius + slip, -radius - slip, 0.5 * radius])
    draft.pegs.append((px + off * nx, py + off * ny, radius))
    draft.walls += cut(draft.choice, wall, draft.choice.randint(1, 4), slip)


def doubled(draft: Draft, x: float, y: float) -> None:
    """A slope, and others that cover part of it or lie 1e-9 m and less beside it."""
    wall = _slope(draft, x, y)
    x1, y1, x2, y2 = wall
    length = math.hypot(x2 - x1, y2 - y1)
    draft.walls += cut(draft.choice, wall, draft.choice.randint(1, 3))
    for _ in range(draft.choice.randint(1, 3)):
        low, high = draft.choice.choice(
            [(0.0, 1.0), (0.0, draft.choice.random()), (-0.2, 0.6), (0.3, 0.7), (0.5, 1.3)]
        )
        ends = [
            (x1, y1) if low == 0.0 else _between(wall, low),
            (x2, y2) if high == 1.0 else _between(wall, high),
        ]
        off = draft.choice.choice(SLIPS) / length
        ends = [(px + off * (y1 - y2), py + off * (x2 - x1)) for px, py in ends]
        if draft.choice.random() < 0.3:
            ends.reverse()
        draft.walls.append((*ends[0], *ends[1]))


def crossed(draft: Draft, x: float, y: float) -> None:
    """Two walls that cross, or one that ends on another."""
    first = _slope(draft, x, y)
    draft.walls += cut(draft.choice, first, draft.choice.randint(1, 3))
    px, py = _between(first, draft.choice.uniform(0.1, 0.9))
    angle, length = draft.choice.uniform(0.0, 6.3), draft.choice.choice([0.02, 0.1, 0.3])
    dx, dy = length * math.cos(angle), length * math.sin(angle)
    back = draft.choice.choice([0.0, 0.0, 0.5, 1.0])
    draft.walls.append((px - back * dx, py - back * dy, px + dx, py + dy))


def fan(draft: Draft, x: float, y: float) -> None:
    """Three to five walls that share an end."""
    for _ in range(draft.choice.randint(3, 5)):
        angle, length = draft.choice.uniform(0.0, 6.3), draft.choice.choice([0.03, 0.1, 0.3])
        draft.walls.append((x, y, x + length * math.cos(angle), y + length * math.sin(angle)))


RECIPES: Final[tuple[Recipe, ...]] = (
    ramp, ramp, ramp, bend, bend, zigzag, zigzag, polygon, tangent_peg, tangent_peg,
    doubled, doubled, crossed, fan, corner_of_walls, peg_on_a_wall, funnel, shelves, chute,
    notch_of_pegs, overhangs,
)  # fmt: skip


def _form(choice: Random) -> dict[str, Any]:
    """The JSON form of a random board; the validator may refuse it."""
    drag = choice.choice(DRAGS)
    draft = Draft(choice, choice.choice(RADII), choice.choice([9.81, 9.81, 1.62, 24.79]), drag)
    names: list[str] = []
    height = choice.uniform(0.5, 0.9)
    while height < 2.0 and len(names) < 3:
        recipe = choice.choice(RECIPES)
        names.append(recipe.__name__)
        recipe(draft, choice.uniform(-0.6, 0.6), height)
        height += choice.uniform(0.4, 0.8)
    _cut_some(draft)
    _add_pegs(draft)
    return _board_form(draft, " ".join(names))


def _cut_some(draft: Draft) -> None:
    """Cut some of the walls, the side walls among them."""
    sides = [(-SIDE, -0.3, -SIDE, BOTTOM), (SIDE, -0.3, SIDE, BOTTOM)]
    walls, draft.walls = draft.walls + sides, []
    share = draft.choice.choice([0.0, 0.3, 0.7])
    for wall in walls:
        if draft.choice.random() < share:
            slip = draft.choice.choice(SLIPS)
            draft.walls += cut(draft.choice, wall, draft.choice.randint(2, 4), slip)
        else:
            draft.walls.append(wall)


def _add_pegs(draft: Draft) -> None:
    """Add pegs from which balls arrive from all directions and with spin."""
    for _ in range(draft.choice.randint(0, 6)):
        at = draft.choice.uniform(-0.8, 0.8), draft.choice.uniform(0.3, 2.0)
        peg = *at, draft.choice.choice([0.01, 0.03, 0.1])
        if draft.gap_beside(*peg) > 2.0 * draft.radius + 0.01:
            draft.pegs.append(peg)


def _board_form(draft: Draft, name: str) -> dict[str, Any]:
    choice = draft.choice
    contact = {"restitution": choice.choice(RESTITUTIONS), "friction": choice.choice(FRICTIONS)}
    wall = contact if choice.random() < 0.6 else contact | {"friction": choice.choice(FRICTIONS)}
    return {
        "name": name,
        "width": 2.0 * SIDE,
        "height": BOTTOM,
        "gravity": draft.gravity,
        "drag": draft.drag,
        "ball": {"radius": draft.radius, **contact},
        "peg_material": contact,
        "wall_material": wall,
        "pegs": [{"x": x, "y": y, "radius": r} for x, y, r in draft.pegs],
        "walls": [{"x1": a, "y1": b, "x2": c, "y2": d} for a, b, c, d in draft.walls],
        "bins": {"y": BOTTOM, "edges": [-SIDE, -0.5, 0.0, 0.5, SIDE]},
        "drop": {"x": 0.0, "jitter": SIDE - draft.radius - 0.02},
    }


def made(choice: Random) -> Board:
    """A board of these choices: the first of its drafts that the validator accepts."""
    while True:
        try:
            return Board.from_json(_form(choice))
        except BoardError:
            continue


def wall_board(number: int) -> Board:
    """Board `number`."""
    return made(Random(f"walls {number}"))


def wall_pair(number: int) -> tuple[Board, Board]:
    """Two boards of the same surface: a straight wall below pegs, whole and in two to seven pieces.

    The joints of every other pair are exactly on the wall; those of the others are rounded.
    """
    choice = Random(f"pair {number}")
    while True:
        draft = Draft(
            choice,
            choice.choice(RADII),
            choice.choice([9.81, 1.62, 24.79]),
            choice.choice([0.0, 0.0, 0.0, 0.5, 2.0, 10.0]),
        )
        pieces = choice.randint(2, 7)
        wall = _slope(draft, choice.uniform(-0.5, 0.5), choice.uniform(0.9, 1.8))
        if number % 2:
            parts = cut(choice, wall, pieces)
        else:
            step = [round((wall[i + 2] - wall[i]) / pieces * 4096) / 4096 for i in (0, 1)]
            first = [round(wall[i] * 4096) / 4096 for i in (0, 1)]
            at = [(first[0] + i * step[0], first[1] + i * step[1]) for i in range(pieces + 1)]
            wall, parts = (*at[0], *at[-1]), [(*a, *b) for a, b in pairwise(at)]
        sides = [(-SIDE, -0.3, -SIDE, BOTTOM), (SIDE, -0.3, SIDE, BOTTOM)]
        draft.walls = [wall]
        _add_pegs(draft)
        draft.walls += sides
        form = _board_form(draft, "whole")
        ends = [dict(zip(("x1", "y1", "x2", "y2"), w, strict=True)) for w in (*parts, *sides)]
        try:
            return Board.from_json(form), Board.from_json(form | {"name": "cut", "walls": ends})
        except BoardError:
            continue


def seeds_of(number: int, drops: int) -> range:
    """Seeds for drops on board `number`, other ones than on the others."""
    return range(number << 20, (number << 20) + drops)


wall_boards: Final = st.integers(0, 1_000_000).map(wall_board)


def _report(failures: list[Failure], shown: int) -> None:
    kinds = Counter(failure.kind for failure in failures)
    for kind, count in kinds.most_common():
        boards = {failure.number for failure in failures if failure.kind == kind}
        sys.stdout.write(f"{kind}: {count} drops on {len(boards)} boards\n")
        for failure in [f for f in failures if f.kind == kind][:shown]:
            sys.stdout.write(f"    {failure}\n")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("first", type=int, help="number of the first board")
    parser.add_argument("count", type=int, help="number of boards")
    parser.add_argument("drops", type=int, help="drops on each")
    parser.add_argument("--pairs", action="store_true", help="compare whole and cut walls instead")
    parser.add_argument("--shown", type=int, default=5, help="failures printed of each kind (5)")
    given = parser.parse_args()
    begun = time.perf_counter()
    failures: list[Failure] = []
    for number in range(given.first, given.first + given.count):
        seeds = seeds_of(number, given.drops)
        if given.pairs:
            failures += compare_drops(*wall_pair(number), seeds, number)
        else:
            failures += check_drops(wall_board(number), seeds, number)
    _report(failures, given.shown)
    sys.stdout.write(
        f"{len({(f.number, f.x) for f in failures})} of {given.count * given.drops} drops fail, "
        f"in {time.perf_counter() - begun:.0f} s\n"
    )
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
