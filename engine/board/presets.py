"""The boards that come with the engine: triangles of 8 to 16 rows in each world, classic, Galton.

Coordinates are computed with + - * / and sqrt only, so they have the same bits on every machine.
Each left half mirrors the right half exactly, so a mirrored start lands in the mirrored bin.
"""

import math
from collections.abc import Mapping
from typing import Final, NamedTuple

from plinko.engine.board import payouts
from plinko.engine.board.fields import BoardFields
from plinko.engine.board.materials import REFERENCE_DENSITY, Material
from plinko.engine.board.parts import BallSpec, Bins, DropZone, Peg, Wall
from plinko.engine.board.worlds import TABLE_GRAVITY, WORLDS, World
from plinko.engine.constants import EARTH_GRAVITY
from plinko.engine.errors import BoardError


class Tuning(NamedTuple):
    """The parameters of a preset that its geometry does not determine.

    drag in 1/s; restitution and friction, the same for ball, pegs and walls; jitter of the start as
    a fraction of the peg spacing; gravity in m/s^2; start: the y of a triangle's starts in m.
    """

    drag: float
    restitution: float
    friction: float
    jitter: float
    gravity: float = EARTH_GRAVITY
    start: float = 0.0


TUNING: Final = {
    "triangle-8": Tuning(3.732, 0.7, 0.402, 0.509, TABLE_GRAVITY),
    "triangle-9": Tuning(3.262, 0.632, 0.409, 0.73, TABLE_GRAVITY),
    "triangle-10": Tuning(3.439, 0.637, 0.248, 0.462, TABLE_GRAVITY),
    "triangle-11": Tuning(3.869, 0.667, 0.274, 0.685, TABLE_GRAVITY),
    "triangle-12": Tuning(4.719, 0.784, 0.324, 0.211, TABLE_GRAVITY),
    "triangle-13": Tuning(4.139, 0.676, 0.245, 0.583, TABLE_GRAVITY),
    "triangle-14": Tuning(4.917, 0.781, 0.415, 0.557, TABLE_GRAVITY),
    "triangle-15": Tuning(4.533, 0.718, 0.339, 0.218, TABLE_GRAVITY),
    "triangle-16": Tuning(4.936, 0.749, 0.588, 0.109, TABLE_GRAVITY, start=0.2),
    "classic": Tuning(drag=1.5, restitution=0.6, friction=0.15, jitter=0.28),
    "galton": Tuning(drag=2.2, restitution=0.5, friction=0.1, jitter=0.4),
}
"""Physics of the house table's presets; `calibrate` chose that of the triangles."""

AIM: Final[Mapping[str, float]] = {"triangle-9": 0.07, "triangle-16": 0.03, "classic": 4.0}
"""How far from the middle a player may aim on a preset and its payout variants, in peg spacings.

Within this distance all their payout tables return 95 % to 99.2 % from each aim. On every other
triangle, `plinko.engine.payouts.table` found no such table of the familiar shape for at least one
risk: the bins that decide the return are hit at different rates as soon as the start moves. A table
of another shape, or for a narrower aim, may exist."""

# The reference game's canvas, 760 x 570 pixels, at 100 pixels a metre.
TRIANGLE_WIDTH: Final = 7.6
TRIANGLE_HEIGHT: Final = 5.7
_FIRST_ROW_Y: Final = 0.36
_LAST_ROW_Y: Final = 5.42
_PEG_SPAN: Final = 6.56  # between the outermost pegs of the last row
_REACH: Final = 0.8  # largest distance of a start from the middle, in spacings
_JITTER: Final = 0.3  # of a start in a world, in spacings
_WALL_GAP: Final = 0.25  # distance of a wall from the outermost pegs, in spacings

HOUSE: Final = "house"
"""The world of the presets `triangle-…`, the house table, and of `classic` and `galton`."""


class Variant(NamedTuple):
    """What a triangle's name says: its world, rows, and the risk of its payout table."""

    world: str
    rows: int
    risk: payouts.Risk

    @property
    def plain(self) -> str:
        """The name of the variant of medium risk, which has no suffix."""
        return f"{'triangle' if self.world == HOUSE else self.world}-{self.rows}"

    @property
    def name(self) -> str:
        return self.plain if self.risk == "medium" else f"{self.plain}-{self.risk}"


_VARIANTS: Final = tuple(
    Variant(world, rows, risk)
    for world in (HOUSE, *WORLDS)
    for rows in payouts.ROWS
    for risk in payouts.RISKS
)

VARIANTS: Final[Mapping[str, Variant]] = {each.name: each for each in _VARIANTS}
"""Every triangle by its name."""


HOUSE_NAMES: Final = (
    *(each.name for each in _VARIANTS if each.world == HOUSE),
    "classic",
    "galton",
)
"""Names of the house table's presets."""

_NAMES: Final = (*HOUSE_NAMES, *(each.name for each in _VARIANTS if each.world != HOUSE))


def plain_name(name: str) -> str:
    """The preset of which `name` is a payout variant; both boards move a ball in the same way."""
    return VARIANTS[name].plain if name in VARIANTS else name


def risk_of(name: str) -> payouts.Risk:
    """The risk of a preset's payout table; medium for a preset without variants."""
    return VARIANTS[name].risk if name in VARIANTS else "medium"


def preset_names() -> tuple[str, ...]:
    """Names of all presets; a triangle's name without a suffix means the medium payout table."""
    return _NAMES


def payouts_of(name: str) -> tuple[float, ...]:
    """The multipliers of a triangle's bins, left to right, without laying out the board."""
    rows, table = VARIANTS[name].rows, payouts.TABLES.get(name)
    # Until its table is solved, each bin returns the stake.
    return payouts.both_halves(table.half, rows) if table else (1.0,) * (rows + 1)


def preset_fields(name: str) -> BoardFields:
    """Return the fields of the preset `name`; BoardError for an unknown name."""
    if name == "classic":
        return _classic()
    if name == "galton":
        return _galton()
    if name in VARIANTS:
        return _triangle_of(name)
    shown = repr(name)[:60]
    raise BoardError(
        f"board is {shown}: there is no such preset; the presets are {', '.join(preset_names())}",
        field="board",
    )


def _triangle_of(name: str) -> BoardFields:
    variant = VARIANTS[name]
    rows, plain, payout = variant.rows, variant.plain, payouts_of(name)
    if variant.world == HOUSE:
        return triangle(name, rows, payout, TUNING[plain], _REACH, AIM.get(plain, 0.0))
    world = WORLDS[variant.world]
    tuning = Tuning(world.drag, world.restitution, world.friction, _JITTER, world.gravity)
    return triangle(name, rows, payout, tuning, _REACH, world=world)


def spacing_of(rows: int) -> float:
    """Distance between neighbouring pegs in a row of a triangle, m."""
    return _PEG_SPAN / (rows + 1)


def triangle(
    name: str,
    rows: int,
    multipliers: tuple[float, ...],
    tuning: Tuning,
    reach: float = 0.0,
    aim: float = 0.0,
    world: World | None = None,
) -> BoardFields:
    """Lay out the triangular board of `rows` rows in the reference game's proportions.

    reach, aim: how far from the middle a ball may start and a player may aim, in peg spacings.
    world: its sizes; default is the house table, whose pegs and balls are smaller on more rows.
    Row i, counted from 0, has i + 3 pegs; the rows + 2 pegs of the last row separate rows + 1 bins.
    """
    size = world.size if world else 1.0
    spacing = size * spacing_of(rows)
    first_row, last_row, height = (size * y for y in (_FIRST_ROW_Y, _LAST_ROW_Y, TRIANGLE_HEIGHT))
    pitch = (last_row - first_row) / (rows - 1)
    peg_radius = world.peg * spacing if world else (24 - rows) / 200
    ball_radius = world.ball * spacing if world else 2.0 * peg_radius
    radii = peg_radius, ball_radius
    walls = _slanted_walls(rows, spacing, radii, (first_row, last_row, height))
    # The bins' line is one ball radius b below the last row. A ball's centre stays at least a peg
    # radius p more than b from a peg's, so on the line it is at least sqrt((b + p)^2 - b^2) to the
    # side of one. A further impact on a peg only pushes it down. So the ball can no longer change
    # its bin, and no rounding decides which one it is.
    line = last_row + ball_radius
    side = walls[2]
    outer = side.x1 + (side.x2 - side.x1) * ((line - side.y1) / (side.y2 - side.y1))
    inner = tuple(spacing * (0.5 * (2 * j - rows - 1)) for j in range(1, rows + 1))
    material = Material(tuning.restitution, tuning.friction)
    return BoardFields(
        name=name,
        width=size * TRIANGLE_WIDTH,
        height=height,
        gravity=tuning.gravity,
        drag=tuning.drag,
        ball=BallSpec(ball_radius, REFERENCE_DENSITY, tuning.restitution, tuning.friction),
        pegs=tuple(
            Peg(spacing * (0.5 * (2 * j - i - 2)), first_row + i * pitch, peg_radius)
            for i in range(rows)
            for j in range(i + 3)
        ),
        peg_material=material,
        walls=walls,
        wall_material=material,
        bins=Bins(line, (-outer, *inner, outer), multipliers),
        drop=DropZone(
            y=size * tuning.start,
            jitter=tuning.jitter * spacing,
            reach=reach * spacing,
            aim=aim * spacing,
        ),
    )


def _slanted_walls(
    rows: int, spacing: float, radii: tuple[float, float], heights: tuple[float, float, float]
) -> tuple[Wall, Wall, Wall, Wall]:
    """Return four walls: right mouth, left mouth, right side, left side.

    A side runs a quarter of a spacing outside the outermost pegs. It leans inward as it rises, so
    that a ball in the corner between wall and peg rolls back onto the board. The side ends at the
    height where a ball in the topmost corner touches the wall. Above it a mouth opens outward at
    45 degrees and makes room for the start.

    radii: peg and ball. heights: y of the first row, of the last row, and where the walls end.
    """
    peg_radius, ball_radius = radii
    first_row, last_row, height = heights
    ball = ball_radius / peg_radius
    slope = 0.5 * spacing / ((last_row - first_row) / (rows - 1))
    secant = math.sqrt(1.0 + slope * slope)
    # The centre of a ball between side and topmost peg is `ball` + 1 peg radii up the slope from
    # the peg's. It touches the wall `ball` peg radii from there, along the wall's normal.
    neck_y = first_row - peg_radius * (ball + 1.0 + ball * slope) / secant
    neck_x = spacing * (1.0 + _WALL_GAP) - slope * (first_row - neck_y)
    foot_x = spacing * (0.5 * (rows + 1) + _WALL_GAP) + slope * (height - last_row)
    top_y = -ball_radius
    top_x = neck_x + (neck_y - top_y)
    return (
        Wall(top_x, top_y, neck_x, neck_y),
        Wall(-top_x, top_y, -neck_x, neck_y),
        Wall(neck_x, neck_y, foot_x, height),
        Wall(-neck_x, neck_y, -foot_x, height),
    )


def _staggered(
    name: str,
    columns: int,
    rows: int,
    spacing: float,
    radii: tuple[float, float],
    multipliers: tuple[float, ...],
    tuning: Tuning,
    slots: tuple[float, ...] = (),
    reach: float = 0.0,
    aim: float = 0.0,
) -> BoardFields:
    """Lay out a rectangular board of `columns` bins under an odd number of `rows` of pegs.

    Even rows, including the first and the last, have a peg above each bin edge. Their outermost
    pegs are centred on the walls, so that a ball is led inward and cannot wedge there. Odd rows
    have a peg above each bin's middle. radii: the peg's and the ball's in m.
    """
    peg_radius, ball_radius = radii
    pitch = spacing * 0.875  # nearly equilateral
    top = 2.0 * spacing
    last_row = top + pitch * (rows - 1)
    line = last_row + ball_radius  # where the ball can no longer change its bin, as on a triangle
    height = line + spacing
    edges = tuple(spacing * (0.5 * (2 * j - columns)) for j in range(columns + 1))
    middles = tuple(spacing * (0.5 * (2 * j - columns + 1)) for j in range(columns))
    material = Material(tuning.restitution, tuning.friction)
    return BoardFields(
        name=name,
        width=spacing * (columns + 1),
        height=height,
        gravity=tuning.gravity,
        drag=tuning.drag,
        ball=BallSpec(ball_radius, REFERENCE_DENSITY, tuning.restitution, tuning.friction),
        pegs=tuple(
            Peg(x, top + i * pitch, peg_radius)
            for i in range(rows)
            for x in (middles if i % 2 else edges)
        ),
        peg_material=material,
        walls=(
            Wall(edges[-1], -spacing, edges[-1], height),
            Wall(edges[0], -spacing, edges[0], height),
        ),
        wall_material=material,
        bins=Bins(line, edges, multipliers),
        drop=DropZone(
            y=0.5 * spacing,
            jitter=tuning.jitter * spacing,
            slots=slots,
            reach=reach * spacing,
            aim=aim * spacing,
        ),
    )


def _classic() -> BoardFields:
    """Nine slots over nine bins, as on television, the best bin in the middle.

    A slot is straight above the middle of a bin. The seed draws the start around it; the jitter is
    as large as the walls next to the outermost slots permit. The payouts were chosen by hand
    within the bounds of `plinko.engine.payouts`: the prize is in the middle, its neighbours pay
    little.
    """
    spacing = 0.7
    return _staggered(
        "classic",
        columns=9,
        rows=13,
        spacing=spacing,
        radii=(0.06 * spacing, 0.19 * spacing),
        multipliers=payouts.both_halves(payouts.TABLES["classic"].half, 8),
        tuning=TUNING["classic"],
        slots=tuple(spacing * (k - 4) for k in range(9)),
        reach=4.3,
        aim=AIM["classic"],
    )


def _galton() -> BoardFields:
    """Many small pegs and bins, to watch a distribution grow; every bin pays the same."""
    columns, spacing = 33, 0.2
    return _staggered(
        "galton",
        columns=columns,
        rows=29,
        spacing=spacing,
        radii=(0.1 * spacing, 0.15 * spacing),
        multipliers=(0.99,) * columns,
        tuning=TUNING["galton"],
    )
