"""Colours and shapes of pictures, from the page's `static/theme.json`, read at import."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

from plinko.app.errors import InvalidValueError
from plinko.app.settings import static_directory
from plinko.engine.board.presets import VARIANTS
from plinko.engine.json_text import JsonObject

Scheme = Literal["light", "dark"]
SCHEMES: Final[tuple[Scheme, ...]] = ("light", "dark")
_PART: Final = " · "  # separates the parts of a board's name and of a theme's name

Colour = tuple[int, int, int]
"""Red, green, blue, 0 to 255, sRGB."""


@dataclass(frozen=True, slots=True)
class Payout:
    """The colours of bins that pay at least `start` times the stake."""

    start: float
    fill: Colour
    ink: Colour


@dataclass(frozen=True)
class Theme:
    """Colours by name, colours of payouts, and measures of shapes.

    shapes: as in the file; lengths are parts of a radius unless the file says otherwise. ground:
    the name of the pattern printed on the board, by default `rays`. grounds: measures of all
    patterns.
    """

    colours: Mapping[str, Colour]
    payouts: tuple[Payout, ...]
    shapes: JsonObject
    ground: str
    grounds: JsonObject

    def __getitem__(self, name: str) -> Colour:
        return self.colours[name]

    def payout(self, score: float) -> Payout:
        """The colours of a bin that pays `score`: those of the last step up to it."""
        steps = [step for step in self.payouts if score >= step.start]
        return steps[-1] if steps else self.payouts[0]


def parse(text: str) -> Colour:
    """Parse a colour `#rrggbb`; raises ValueError for other text."""
    digits = text.removeprefix("#")
    if len(digits) != 6 or len(text) != 7:
        raise ValueError(f"colour {text!r} is not of the form #rrggbb")
    return int(digits[0:2], 16), int(digits[2:4], 16), int(digits[4:6], 16)


def _theme(data: JsonObject, name: str, place: JsonObject | None = None) -> Theme:
    payouts = tuple(
        Payout(step["from"], parse(step["fill"]), parse(step["ink"])) for step in data["payout"]
    )
    own = place or {"palette": {}, "peg": {}, "ground": "rays"}
    colours = {key: parse(value) for key, value in {**data[name], **own["palette"]}.items()}
    shapes = {**data["shapes"], "peg": {**data["shapes"]["peg"], **own["peg"]}}
    return Theme(colours, payouts, shapes, own["ground"], data["grounds"])


def _load() -> dict[str, Theme]:
    data = json.loads((static_directory() / "theme.json").read_text(encoding="utf-8"))
    themes: dict[str, Theme] = {name: _theme(data, name) for name in SCHEMES}
    for world, place in data["places"].items():
        for name in SCHEMES:
            themes[f"{name}{_PART}{world}"] = _theme(data, name, place)
    return themes


THEMES: Final = _load()
"""The themes `light` and `dark`, and both for each world, such as `light · moon`."""


def named(name: str) -> Theme:
    """The theme called `name`; raises InvalidValueError if there is none."""
    if name not in THEMES:
        raise InvalidValueError(f"theme {name!r:.60} is not light or dark", field="theme")
    return THEMES[name]


def at_place(scheme: str, board_name: str) -> str:
    """The name of the theme in which the page shows a board with this name.

    It is `scheme` itself unless the board is a world's, such as `moon-16`, or has the gravity or
    material of one, such as `triangle-16 · Moon` or `triangle-16 · Glass on glass`.
    Raises InvalidValueError unless the scheme is light or dark.
    """
    if scheme not in SCHEMES:
        raise InvalidValueError(f"theme {scheme!r:.60} is not light or dark", field="theme")
    preset, *changes = board_name.split(_PART)
    variant = VARIANTS.get(preset)
    worlds = [part.split()[0].lower() for part in changes if part.split()]
    themes = (f"{scheme}{_PART}{world}" for world in (*worlds, variant and variant.world))
    return next((theme for theme in themes if theme in THEMES), scheme)
