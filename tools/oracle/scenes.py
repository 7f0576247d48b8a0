"""Boards that show one law at a time, and the boards of the accuracy claims."""

from unittest import mock

from benchmarks.scenes.contact_scenes import trial
from plinko.engine.board.materials import Material
from plinko.engine.board.model import Board
from plinko.engine.board.parts import BallSpec, Bins, DropZone, Peg, Wall

WIDE = Bins(2.0, (-50.0, 0.0, 50.0), (1.0, 1.0))


def scene(
    *,
    pegs: tuple[Peg, ...] = (),
    walls: tuple[Wall, ...] = (),
    restitution: float = 0.0,
    friction: float = 0.0,
    drag: float = 0.0,
    gravity: float = 9.81,
    radius: float = 0.1,
    bins: Bins = WIDE,
    start_y: float = -1.0,
    drop: DropZone | None = None,
) -> Board:
    """A board of a few bodies; all surfaces are alike.

    The checks of the whole board are left out: a scene may have no side walls, and some scenes trap
    the ball on purpose.
    """
    material = Material(restitution, friction)
    with mock.patch("plinko.engine.board.checks.playable.check"):
        return Board(
            name="scene",
            gravity=gravity,
            drag=drag,
            ball=BallSpec(radius, 1.0, restitution, friction),
            pegs=pegs,
            peg_material=material,
            walls=walls,
            wall_material=material,
            bins=bins,
            drop=drop or DropZone(0.0, start_y, 2.0),
        )


def accuracy_boards() -> dict[str, Board]:
    """The boards on which the exact solver is compared with the oracle, by name."""
    trials = {f"trial-{rows}": trial(rows, 0.5, 0.2, 2.0) for rows in (8, 12, 16)}
    named = {f"triangle-{rows}": Board.preset(f"triangle-{rows}") for rows in (8, 12, 16)}
    return named | trials | {"plain-12": trial(12, 0.6, 0.0, 0.0)}
