"""Boards for the engine's tests: arbitrary ones, boxes, mirrored and random ones."""

import math
from dataclasses import replace
from functools import partial
from unittest import mock

from hypothesis import strategies as st

from plinko.engine.board.model import Board
from plinko.engine.board.parts import Bins, DropZone, Peg, Wall
from tools.oracle.scenes import scene

FAR_BELOW = Bins(1000.0, (-1000.0, 0.0, 1000.0), (1.0, 1.0))


place = partial(scene, restitution=0.5, bins=FAR_BELOW, drop=DropZone(0.0, 0.0, 0.0))
"""A board of any parts, without the check that a ball can start and pass."""


def box(
    width: float,
    height: float,
    *,
    pegs: tuple[Peg, ...] = (),
    restitution: float = 1.0,
    friction: float = 0.0,
    drag: float = 0.0,
    radius: float = 0.1,
) -> Board:
    """A closed box from (-width/2, 0) to (width/2, height), with the bins outside."""
    half = 0.5 * width
    corners = ((-half, 0.0), (half, 0.0), (half, height), (-half, height))
    return place(
        pegs=pegs,
        walls=tuple(Wall(*corners[i], *corners[(i + 1) % 4]) for i in range(4)),
        restitution=restitution,
        friction=friction,
        drag=drag,
        radius=radius,
        drop=DropZone(0.0, 0.5 * height, 0.0),
    )


def mirrored(board: Board) -> Board:
    """The board mirrored at x = 0; parts keep their numbers, and the order of bins is reversed."""
    bins, zone = board.bins, board.drop
    with mock.patch("plinko.engine.board.checks.playable.check"):
        return replace(
            board,
            pegs=tuple(Peg(-p.x, p.y, p.radius) for p in board.pegs),
            walls=tuple(Wall(-w.x1, w.y1, -w.x2, w.y2) for w in board.walls),
            bins=Bins(bins.y, tuple(-x for x in bins.edges[::-1]), bins.multipliers[::-1]),
            drop=replace(zone, x=-zone.x, slots=tuple(-x for x in zone.slots)),
        )


def _crossed(
    pegs: list[tuple[float, float, float]],
    walls: list[tuple[float, float, float, float]],
    restitution: float,
    friction: float,
    drag: float,
) -> Board:
    """A board 2.4 m wide of pegs that do not overlap, and of walls (x, y, length, turn)."""
    kept: list[Peg] = []
    for peg in (Peg(*values) for values in pegs):
        if all(math.hypot(peg.x - p.x, peg.y - p.y) > peg.radius + p.radius for p in kept):
            kept.append(peg)
    slanted = tuple(
        Wall(x, y, x + length * math.cos(turn), y + length * math.sin(turn))
        for x, y, length, turn in walls
    )
    return place(
        pegs=tuple(kept),
        walls=(*slanted, Wall(-1.2, -1.0, -1.2, 3.0), Wall(1.2, -1.0, 1.2, 3.0)),
        restitution=restitution,
        friction=friction,
        drag=drag,
        bins=Bins(3.0, (-2.0, 0.0, 2.0), (1.0, 1.0)),
        drop=DropZone(0.0, -0.5, 1.0),
    )


any_board: st.SearchStrategy[Board] = st.builds(
    _crossed,
    pegs=st.lists(
        st.tuples(st.floats(-0.9, 0.9), st.floats(0.4, 2.4), st.floats(0.02, 0.15)), max_size=8
    ),
    walls=st.lists(
        st.tuples(
            st.floats(-0.9, 0.9), st.floats(0.5, 2.4), st.floats(0.1, 1.2), st.floats(-1.4, 1.4)
        ),
        max_size=4,
    ),
    restitution=st.sampled_from([0.0, 0.3, 0.6, 0.9]),
    friction=st.sampled_from([0.0, 0.1, 0.6, 2.0]),
    drag=st.sampled_from([0.0, 1.0, 4.0]),
)
"""Boards of any parts, including traps and crossing walls."""
