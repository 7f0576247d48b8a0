"""A Plinko board: frozen data, checked once when it is made, with a digest of its content."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from engine.board import digest as board_digest
from engine.board import json_form, values
from engine.board.checks import playable
from engine.board.materials import Material
from engine.board.parts import BallSpec, Bins, DropZone, Peg, Wall
from engine.constants import EARTH_GRAVITY

__all__ = ["BallSpec", "Bins", "Board", "DropZone", "Material", "Peg", "Wall"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Board:
    """Everything that decides where a ball goes, besides its seed.

    Lengths in m (x right, y down), gravity in m/s^2, linear drag in 1/s. `width` and `height` are
    those of the picture, x from -width/2 to width/2 and y from 0 to height; the physics does not
    read them. Raises BoardError whose message and `field` name the value that is wrong.
    """

    name: str = "board"
    width: float = json_form.DEFAULT_WIDTH
    height: float = json_form.DEFAULT_HEIGHT
    gravity: float = EARTH_GRAVITY
    drag: float = 0.0
    ball: BallSpec = field(default_factory=BallSpec)
    pegs: tuple[Peg, ...] = ()
    peg_material: Material = field(default_factory=Material)
    walls: tuple[Wall, ...] = ()
    wall_material: Material = field(default_factory=Material)
    bins: Bins
    drop: DropZone = field(default_factory=DropZone)
    digest: str = field(init=False, repr=False, compare=False)
    """SHA-256 of the content, 64 hex digits; the bytes are laid out in `board_digest`."""

    def __post_init__(self) -> None:
        """Put checked floats in place of what was given, then check the board as a whole."""
        checked: dict[str, Any] = {
            "name": values.name(self.name),
            "width": values.size(self.width, "width"),
            "height": values.size(self.height, "height"),
            "gravity": values.gravity(self.gravity),
            "drag": values.drag(self.drag),
            "ball": values.ball(self.ball),
            "pegs": values.pegs(self.pegs),
            "peg_material": values.material(self.peg_material, "peg_material"),
            "walls": values.walls(self.walls),
            "wall_material": values.material(self.wall_material, "wall_material"),
            "bins": values.bins(self.bins),
            "drop": values.drop_zone(self.drop),
        }
        for key, value in checked.items():
            object.__setattr__(self, key, value)
        object.__setattr__(self, "digest", board_digest.digest(self))
        playable.check(self)

    def __hash__(self) -> int:
        return hash(self.digest)

    @classmethod
    def preset(cls, name: str) -> "Board":
        """Return the preset `name`, one of `preset_names()`; BoardError if there is none."""
        from engine.board import presets  # noqa: PLC0415 - presets are made of boards

        return presets.preset(name)

    @classmethod
    def from_json(cls, source: str | os.PathLike[str] | Mapping[str, Any]) -> "Board":
        """Make a board of its JSON form: text (starts with `{`), the path of a file, or a dict."""
        return cls(**json_form.fields(json_form.load(source)))

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form as a new dict."""
        return json_form.to_dict(self)

    def to_json(self) -> str:
        """Return the JSON form as text; `Board.from_json` of it is this board again."""
        return json_form.dumps(self)

    @property
    def slots(self) -> tuple[float, ...]:
        """Explicit starts offered to the player, x in m; often none."""
        return self.drop.slots

    @property
    def preset_name(self) -> str | None:
        """Name of the preset that this board equals, or None."""
        from engine.board import presets  # noqa: PLC0415 - presets are made of boards

        known = self.name in presets.preset_names()
        return self.name if known and presets.preset(self.name) == self else None

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """x_min, x_max, y_min, y_max in m of the picture and all parts of the board.

        A ball's whole disc is inside from its start until it lands, on every valid board whose
        sides are walled; on others it may leave at the sides for a moment.
        """
        reach = self.ball.radius
        half = 0.5 * self.width
        zone, bins = self.drop, self.bins
        xs = [-half, half, bins.edges[0], bins.edges[-1]]
        xs += [zone.x - zone.span - reach, zone.x + zone.span + reach]
        xs += [x + side for x in zone.slots for side in (-reach, reach)]
        ys = [0.0, self.height, zone.y - reach, bins.y + reach]
        for peg in self.pegs:
            xs += (peg.x - peg.radius, peg.x + peg.radius)
            ys += (peg.y - peg.radius, peg.y + peg.radius)
        for wall in self.walls:
            xs += (wall.x1, wall.x2)
            ys += (wall.y1, wall.y2)
        return min(xs), max(xs), min(ys), max(ys)
