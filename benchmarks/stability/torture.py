"""The torture catalogue: scenes made to break a solver, many of which the validator refuses."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any
from unittest import mock

import numpy as np

from benchmarks.scenes import boards
from plinko.engine import Board
from plinko.engine.board.checks import playable
from plinko.engine.board.materials import Material
from plinko.engine.board.parts import BallSpec, Bins, DropZone, Peg, Wall

PHYSICS = Material(0.6, 0.2)
REACH = 0.15  # m: the ball's 0.1 and a peg's 0.05


@dataclass(frozen=True)
class Torture:
    """A scene, its starts in m, and options of the stepped solver that differ from its defaults."""

    name: str
    board: Board
    xs: Sequence[float]
    stepped: dict[str, Any] = field(default_factory=dict)


def catalogue(starts: int) -> Iterator[Torture]:
    """All scenes; each larger one has `starts` random starts."""
    yield from _aimed()
    yield from _traps()
    yield from _extremes(starts)


def _near(x: float, units: int = 8) -> list[float]:
    """x and the floats next to it."""
    return [x + k * float(np.spacing(x or 1e-300)) for k in range(-units, units + 1)]


def _scene(
    *,
    pegs: Sequence[Peg] = (),
    walls: Sequence[Wall] = (),
    physics: Material = PHYSICS,
    drag: float = 0.5,
    start: float = -1.0,
) -> Board:
    with mock.patch.object(playable, "check"):
        return Board(
            name="torture",
            drag=drag,
            ball=BallSpec(0.1, 80.0, physics.restitution, physics.friction),
            pegs=tuple(pegs),
            peg_material=physics,
            walls=tuple(walls),
            wall_material=physics,
            bins=Bins(
                2.0, (-1e6, 0.0, 1e6), (1.0, 1.0)
            ),  # wide: a ball dropped from 100 km bounces far away
            drop=DropZone(0.0, start, 0.5),
        )


def _aimed() -> Iterator[Torture]:
    peg = (Peg(0.0, 0.0, 0.05),)
    row = tuple(Peg(0.1 * i, 0.3, 0.05) for i in range(-3, 4))
    for e, mu in ((0.0, 0.0), (0.0, 0.5), (0.5, 0.2), (1.0, 0.0), (1.0, 10.0)):
        physics = Material(e, mu)
        suffix = f"e {e:g}, mu {mu:g}"
        board = _scene(pegs=peg, physics=physics)
        tiny = [s * 10.0**-k for k in range(3, 300, 27) for s in (1, -1)]
        yield Torture(f"apex of a peg, {suffix}", board, [*_near(0.0), *tiny])
        yield Torture(f"grazing a peg, {suffix}", board, [*_near(REACH), *_near(-REACH)])
        yield Torture(
            f"a row of touching pegs, {suffix}",
            _scene(pegs=row, physics=physics),
            np.linspace(-0.45, 0.45, 41).tolist(),
        )
        slope = (Wall(-0.3, 0.0, 0.3, 0.25),)
        yield Torture(
            f"a bar and its ends, {suffix}",
            _scene(walls=slope, physics=physics),
            [*np.linspace(-0.45, 0.45, 41), -0.3, 0.3, -0.4, 0.4],
        )
        upright = (Wall(0.0, 0.0, 0.0, 0.5),)
        yield Torture(
            f"an upright bar from above, {suffix}",
            _scene(walls=upright, physics=physics),
            [*_near(0.0), *_near(0.1), *_near(-0.1)],
        )


def _traps() -> Iterator[Torture]:
    spread = np.linspace(-0.3, 0.3, 21).tolist()
    for e, mu in ((0.0, 0.0), (0.5, 0.3), (0.9, 1.0)):
        physics = Material(e, mu)
        suffix = f"e {e:g}, mu {mu:g}"
        pegs = (Peg(-0.13, 0.0, 0.05), Peg(0.13, 0.0, 0.05))
        yield Torture(f"a notch of two pegs, {suffix}", _scene(pegs=pegs, physics=physics), spread)
        bars = (Wall(-0.5, -0.5, 0.0, 0.5), Wall(0.5, -0.5, 0.0, 0.5))
        yield Torture(f"a V of two bars, {suffix}", _scene(walls=bars, physics=physics), spread)
        corner = (Wall(-0.5, 0.5, 0.5, 0.5), Wall(0.5, 0.5, 0.5, -0.5))
        yield Torture(f"floor and wall, {suffix}", _scene(walls=corner, physics=physics), spread)
        closed = (
            Wall(-0.6, -1.5, 0.6, -1.5),
            Wall(-0.6, 0.5, 0.6, 0.5),
            Wall(-0.6, -1.5, -0.6, 0.5),
            Wall(0.6, -1.5, 0.6, 0.5),
        )
        yield Torture(f"a closed box, {suffix}", _scene(walls=closed, physics=physics), spread)


def _extremes(starts: int) -> Iterator[Torture]:
    board = boards.triangle(8, boards.FULL)
    zone = board.drop
    xs = np.random.default_rng(5).uniform(-zone.jitter, zone.jitter, starts).tolist()
    for density in (1e-9, 1e9):
        ball = replace(board.ball, density=density)
        yield Torture(f"density {density:g} kg/m^2", replace(board, ball=ball), xs)
    for gravity in (1e-6, 1e-2, 1e4):
        yield Torture(f"gravity {gravity:g} m/s^2", boards.revised(board, gravity=gravity), xs)
    for drag in (0.0, 1e-9, 30.0, 1e3):
        few = xs if drag < 100.0 else xs[:2]
        yield Torture(f"drag {drag:g} 1/s", boards.revised(board, drag=drag), few)
    for e, mu in ((0.0, 0.0), (0.0, 10.0), (1.0, 0.0), (1.0, 10.0)):
        material = Material(e, mu)
        ball = replace(board.ball, restitution=e, friction=mu)
        changed = replace(board, ball=ball, peg_material=material, wall_material=material)
        yield Torture(f"triangle-8 with e {e:g}, mu {mu:g}", changed, xs)
    for dt, substeps in ((0.1, 1), (1e-4, 1), (1.0 / 60.0, 100)):
        options = {"dt": dt, "substeps": substeps}
        yield Torture(f"dt {dt:.3g} s, {substeps} substeps", board, xs[:20], options)
    peg = (Peg(0.0, 0.0, 0.05),)
    high = _scene(pegs=peg, start=-1e5, drag=0.0)
    yield Torture("dropped from 100 km", high, [*_near(0.0), *_near(REACH), 0.05, -0.1])
    yield Torture("dropped from 1 nm above", _scene(pegs=peg, start=-REACH - 1e-9), _near(0.0))
