"""Boards shared by the benchmarks: triangles, lattices, and scenes that the validator refuses."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any
from unittest import mock

from plinko.engine.board import presets
from plinko.engine.board.checks import playable
from plinko.engine.board.materials import REFERENCE_DENSITY, Material
from plinko.engine.board.model import Board
from plinko.engine.board.parts import BallSpec, Bins, DropZone, Peg, Wall

PLAIN = presets.Tuning(drag=0.0, restitution=0.6, friction=0.0, jitter=0.8)
"""No drag, no friction: every other engine can simulate this."""

FULL = presets.Tuning(drag=2.2, restitution=0.65, friction=0.15, jitter=0.8)
"""Drag, friction, spin, and the rolling and sliding that they cause."""

THIN = PLAIN._replace(restitution=0.5)
"""For the lattice: bounces are so low that most balls hit one peg in each row."""

SPACING = 0.6  # m between the pegs of a lattice: a ball fits between a peg and a wall
PEG_RADIUS = 0.05
BALL_RADIUS = 0.1


def triangle(rows: int, tuning: presets.Tuning) -> Board:
    """The reference game's triangular board with the physics of `tuning`."""
    name = f"{'plain' if tuning is PLAIN else 'trial'}-{rows}"
    return Board.of(presets.triangle(name, rows, presets.payouts_of(f"triangle-{rows}"), tuning))


def lattice(rows: int, columns: int, tuning: presets.Tuning) -> Board:
    """A staggered rectangle of pegs; drops from its middle are similar for every size.

    Odd rows have `columns` pegs. Even rows have one more; half of their outermost pegs is inside
    the walls.
    """
    pitch = 0.875 * SPACING
    top = 2.0 * SPACING
    edges = [SPACING * (j - 0.5 * columns) for j in range(columns + 1)]
    middles = [SPACING * (j + 0.5 - 0.5 * columns) for j in range(columns)]
    line = top + pitch * (rows - 1) + BALL_RADIUS
    material = Material(tuning.restitution, tuning.friction)
    return Board(
        name=f"lattice-{rows}x{columns}",
        width=SPACING * (columns + 1),
        height=line + SPACING,
        drag=tuning.drag,
        ball=BallSpec(BALL_RADIUS, REFERENCE_DENSITY, tuning.restitution, tuning.friction),
        pegs=tuple(
            Peg(x, top + i * pitch, PEG_RADIUS)
            for i in range(rows)
            for x in (middles if i % 2 else edges)
        ),
        peg_material=material,
        walls=tuple(Wall(x, -SPACING, x, line + SPACING) for x in (edges[0], edges[-1])),
        wall_material=material,
        bins=Bins(line, tuple(edges), tuple(1.0 for _ in middles)),
        drop=DropZone(0.0, 0.5 * SPACING, tuning.jitter * SPACING),
    )


def unchecked(
    *,
    pegs: Sequence[Peg] = (),
    walls: Sequence[Wall] = (),
    restitution: float,
    start: tuple[float, float],
    jitter: float = 0.0,
    floor: float = 1e5,
    gravity: float = 9.81,
) -> Board:
    """A scene that the validator would refuse, such as a closed box or a bare floor.

    It has no friction and no drag. Values are checked, but not how the parts lie to each other.
    `floor` is the height of the bins' line in m, by default far out of reach.
    """
    material = Material(restitution, 0.0)
    with mock.patch.object(playable, "check"):
        return Board(
            name="scene",
            gravity=gravity,
            ball=BallSpec(BALL_RADIUS, REFERENCE_DENSITY, restitution, 0.0),
            pegs=tuple(pegs),
            peg_material=material,
            walls=tuple(walls),
            wall_material=material,
            bins=Bins(floor, (-1e5, 1e5), (1.0,)),
            drop=DropZone(start[0], start[1], jitter),
        )


def revised(board: Board, **changes: Any) -> Board:
    """`board` with some fields changed, without the checks of the whole board."""
    with mock.patch.object(playable, "check"):
        return replace(board, **changes)


def bare_floor(restitution: float, height: float) -> Board:
    """A level floor at y = 0 and a ball whose lowest point starts `height` metres above it."""
    floor = (Wall(-5.0, 0.0, 5.0, 0.0),)
    return unchecked(walls=floor, restitution=restitution, start=(0.0, -height - BALL_RADIUS))


def elastic_box() -> Board:
    """A closed box with nine pegs and no loss of energy: e = 1, no friction, no drag."""
    walls = (
        Wall(-1.5, -1.5, 1.5, -1.5),
        Wall(-1.5, 1.5, 1.5, 1.5),
        Wall(-1.5, -1.5, -1.5, 1.5),
        Wall(1.5, -1.5, 1.5, 1.5),
    )
    pegs = tuple(Peg(0.7 * i, 0.55 * j + 0.5, 0.1) for i in (-1, 0, 1) for j in (-1, 0, 1))
    return unchecked(pegs=pegs, walls=walls, restitution=1.0, start=(0.0, -1.0), jitter=1.2)
