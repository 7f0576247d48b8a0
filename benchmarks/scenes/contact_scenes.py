"""Scenes shared by tests, benchmarks and demos: small boards that show one effect each.

A scene is a valid board (except the level shelf), a description of the effect, and the start that
shows it best. Drops from other seeds of the board show the same effect.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Final

from benchmarks.scenes.boards import revised
from plinko.engine.board import presets
from plinko.engine.board.materials import Material
from plinko.engine.board.model import Board
from plinko.engine.board.parts import BallSpec, Bins, DropZone, Peg, Wall
from plinko.engine.errors import BoardError


@dataclass(frozen=True, slots=True)
class Scene:
    """A board, the effect that it shows, and a start x in m (None: any seed shows it)."""

    name: str
    shows: str
    board: Board
    x: float | None = None


_Maker = Callable[[], Scene]
_MAKERS: Final[dict[str, _Maker]] = {}

_WIDTH: Final = 4.0
_FLOOR: Final = 4.0
_RAMP: Final = Wall(-1.0, 0.6, 0.8, 1.4)


def scene_names() -> tuple[str, ...]:
    return tuple(_MAKERS)


@cache
def scene(name: str) -> Scene:
    """Return the scene `name`; raises BoardError if it does not exist."""
    if name not in _MAKERS:
        raise BoardError(
            f"there is no scene {name!r:.60}; the scenes are {', '.join(_MAKERS)}", field="scene"
        )
    return _MAKERS[name]()


def trial(rows: int, restitution: float, friction: float, drag: float) -> Board:
    """The triangular board of `rows` rows with the given physics, drag in 1/s.

    The start's jitter is 0.8 peg spacings, as in the presets before they were tuned.
    """
    tuning = presets.Tuning(drag, restitution, friction, jitter=0.8)
    payout = presets.payouts_of(f"triangle-{rows}")
    return Board.of(presets.triangle(f"trial-{rows}", rows, payout, tuning))


def _scene(maker: _Maker) -> _Maker:
    _MAKERS[maker.__name__.strip("_").replace("_", "-")] = maker
    return maker


def _chute(
    name: str,
    *,
    pegs: tuple[Peg, ...] = (),
    walls: tuple[Wall, ...] = (),
    restitution: float = 0.5,
    friction: float = 0.2,
    drag: float = 0.0,
    x: float = 0.0,
    jitter: float = 0.02,
    gravity: float = 9.81,
) -> Board:
    """A chute between walls, 4 m wide and 4 m deep, with eight bins; the given walls come first."""
    half = 0.5 * _WIDTH
    surface = Material(restitution, friction)
    sides = tuple(Wall(side, -0.5, side, _FLOOR) for side in (-half, half))
    return Board(
        name=name,
        width=_WIDTH,
        height=_FLOOR,
        gravity=gravity,
        drag=drag,
        ball=BallSpec(0.1, 1.0, restitution, friction),
        pegs=pegs,
        peg_material=surface,
        walls=walls + sides,
        wall_material=surface,
        bins=Bins(_FLOOR, tuple(half * (0.25 * i - 1.0) for i in range(9)), (1.0,) * 8),
        drop=DropZone(x, 0.0, jitter),
    )


@_scene
def _low_restitution() -> Scene:
    board = trial(16, restitution=0.5, friction=0.2, drag=2.0)
    return Scene("low-restitution", "bounces die out: rolling and sliding on most pegs", board)


@_scene
def _plain() -> Scene:
    board = trial(12, restitution=0.6, friction=0.0, drag=0.0)
    return Scene("plain", "no friction and no drag: parabolas and restitution only", board)


@_scene
def _elastic() -> Scene:
    board = trial(12, restitution=1.0, friction=0.0, drag=0.0)
    return Scene("elastic", "nothing is lost: energy stays what it was", board)


@_scene
def _dead() -> Scene:
    board = trial(8, restitution=0.0, friction=0.3, drag=0.5)
    return Scene("dead", "no restitution: every impact begins a contact", board)


@_scene
def _grippy() -> Scene:
    board = trial(12, restitution=0.7, friction=1.5, drag=1.0)
    return Scene("grippy", "friction holds at nearly every impact: the ball spins up", board)


@_scene
def _apex() -> Scene:
    board = _chute("apex", pegs=(Peg(0.0, 1.0, 0.1),))
    return Scene("apex", "a ball exactly above a peg comes to rest on it", board, x=0.0)


@_scene
def _shelf() -> Scene:
    chute = _chute("shelf")
    board = revised(chute, walls=(Wall(-0.5, 1.0, 0.5, 1.0), *chute.walls))
    return Scene("shelf", "a ball comes to rest on a level wall", board, x=0.0)


@_scene
def _ramp() -> Scene:
    board = _chute("ramp", walls=(_RAMP,), restitution=0.2, x=-0.8)
    return Scene("ramp", "a ball rolls down a wall and off its end", board)


@_scene
def _slide() -> Scene:
    board = _chute("slide", walls=(_RAMP,), restitution=0.2, friction=0.0, x=-0.8)
    return Scene("slide", "a ball slides down a frictionless wall and off its end", board)


@_scene
def _zigzag() -> Scene:
    ramps = tuple(
        Wall(side * 2.0, 0.4 + 0.7 * i, -side * 1.2, 0.9 + 0.7 * i)
        for i, side in enumerate((-1.0, 1.0, -1.0, 1.0))
    )
    board = _chute("zigzag", walls=ramps, restitution=0.3, x=-1.5)
    return Scene("zigzag", "a ball rolls from wall to wall", board)


@_scene
def _polyline() -> Scene:
    points = ((-1.6, 0.5), (-0.8, 1.0), (0.0, 1.2), (0.6, 1.9))
    walls = tuple(Wall(*a, *b) for a, b in pairwise(points))
    board = _chute("polyline", walls=walls, restitution=0.2, x=-1.4)
    return Scene("polyline", "a ball rolls over the joints of a bent wall", board)


@_scene
def _comb() -> Scene:
    walls = tuple(Wall(-1.5 + 0.5 * i, 1.5, -1.5 + 0.5 * i, _FLOOR) for i in range(7))
    board = _chute("comb", walls=walls, jitter=1.2)
    return Scene("comb", "a ball bounces on the ends of upright walls", board)


@_scene
def _storm() -> Scene:
    pegs = tuple(
        Peg(-1.6 + 0.4 * i + 0.2 * (j % 2), 0.6 + 0.4 * j, 0.05)
        for j in range(8)
        for i in range(9 - j % 2)
    )
    board = _chute("storm", pegs=pegs, restitution=0.8, gravity=1.0e4, jitter=1.0)
    return Scene("storm", "a thousand times Earth's gravity: impacts at 200 m/s", board)
