"""Scenes of touching balls: their parameters as JSON, as in `POST rooms`, and their arenas."""

import hashlib
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import msgspec

from plinko.app.errors import InvalidValueError
from plinko.app.rooms.touching.values import (
    BALL,
    SETTINGS,
    SINCE_2,
    Range,
    check_work,
    checked,
    for_arena,
)
from plinko.engine import Board
from plinko.engine.errors import RecordError, shorten
from plinko.engine.json_text import JsonObject
from plinko.engine.multibody.arena import Arena
from plinko.engine.multibody.scenes import galton, sandbox
from plinko.engine.seeding import parse_seed

SANDBOX: Final = "sandbox"
GALTON: Final = "galton"

BALLS: Final = Range(0, 1000, "balls", 60, whole=True)
SIDE: Final = Range(0.5, 20.0, "m")
SPEED: Final = Range(0.0, 50.0, "m/s", 0.0)

_GALTON: Final = Board.preset("galton")

_WHOLE: Final = ("balls", "substeps", "projection")

DEFAULTS: Final[dict[str, dict[str, object]]] = {
    SANDBOX: {
        "balls": 60,
        "seed": "1",
        "width": 6.0,
        "height": 4.0,
        "radii": [0.06, 0.16],
        "speed": 0.0,
        **{name: BALL[name].default for name in ("density", "restitution", "friction")},
        **{name: entry.default for name, entry in SETTINGS.items()},
    },
    GALTON: {
        "balls": 300,
        "seed": "1",
        **{name: getattr(_GALTON.ball, name) for name in ("density", "restitution", "friction")},
        **{name: entry.default for name, entry in SETTINGS.items()},
        "gravity": _GALTON.gravity,
        "drag": _GALTON.drag,
    },
}


@dataclass(frozen=True)
class Scene:
    """A scene with all its parameters, validated; equal scenes have equal digests."""

    values: JsonObject

    @classmethod
    def of(cls, values: object, *, tick_rate: int, max_balls: int) -> "Scene":
        """Parse a JSON object (or a scene's name) and add the defaults.

        Raises InvalidValueError, and SeedError for an invalid seed.
        """
        if isinstance(values, str):
            values = {"scene": values}
        if not isinstance(values, dict):
            raise InvalidValueError(f"scene {shorten(values)} is not an object", field="scene")
        name = values.get("scene")
        if not isinstance(name, str) or name not in DEFAULTS:
            known = ", ".join(DEFAULTS)
            raise InvalidValueError(f"scene {shorten(name)} is not one of: {known}", field="scene")
        given = {key: value for key, value in values.items() if value is not None}
        defaults = DEFAULTS[name]
        for key in given:
            if key != "scene" and key not in defaults:
                known = ", ".join(defaults)
                raise InvalidValueError(
                    f"scene {name!r} has no {shorten(key)}; it has: {known}", field=key
                )
        found = dict(_checked({**defaults, **given}, max_balls))
        check_work(found["balls"], found["dt"], found["substeps"], tick_rate)
        for later in SINCE_2:
            if found[later] == SETTINGS[later].default:
                del found[later]
        return cls({"scene": name, **found})

    @property
    def name(self) -> str:
        return str(self.values["scene"])

    @property
    def preset_name(self) -> None:
        """None: only boards have presets."""
        return None

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the parameters, 64 hex digits."""
        return hashlib.sha256(b"plinko scene" + msgspec.json.encode(self.to_dict())).hexdigest()

    def to_dict(self) -> dict[str, object]:
        return dict(sorted(self.values.items()))

    @property
    def radius(self) -> float:
        """The default radius of an added ball, in m."""
        if self.name == GALTON:
            return _GALTON.ball.radius
        low, high = self.values["radii"]
        return 0.5 * float(low + high)

    def build(self) -> Arena:
        """The arena at the start.

        Pegs and walls have restitution 0. An impact uses the greater of the two, so that of the
        ball decides, also after later edits.
        """
        values = for_arena(self.values)
        make = sandbox if values.pop("scene") == SANDBOX else galton
        balls, seed = values.pop("balls"), parse_seed(values.pop("seed"))
        bounce = values.pop("restitution")
        if make is sandbox:
            values["radii"] = tuple(values["radii"])
            arena = sandbox(balls, seed=seed, restitution=0.0, **values)
            arena.edit_all(restitution=bounce)
            return arena
        arena = galton(balls, seed=seed)
        made_of = {name: values.pop(name) for name in ("density", "friction")}
        arena.configure(**values)
        arena.edit_all(restitution=bounce, **made_of)
        arena.edit_place(restitution=0.0, friction=made_of["friction"])
        return arena


def as_kept(values: JsonObject | str) -> dict[str, object]:
    """The parameters in a log, with the types that `Scene.of` gave them.

    JavaScript writes 6.0 as 6, which would give another digest. Raises RecordError if a parameter
    is missing or unknown.
    """
    name = values if isinstance(values, str) else values.get("scene")
    defaults = DEFAULTS.get(name) if isinstance(name, str) else None
    if defaults is None or isinstance(values, str):
        raise RecordError(
            f"scene {shorten(name)} is not one of: {', '.join(DEFAULTS)}", field="scene"
        )
    differs = ", ".join(sorted((values.keys() ^ {"scene", *defaults}) - {*SINCE_2}))
    if differs:
        raise RecordError(
            f"scene {name!r} must have exactly its parameters; missing or unknown: {differs}"
        )
    return {name: value if name in _WHOLE else _as_float(value) for name, value in values.items()}


def _as_float(value: object) -> object:
    """`value` with whole numbers as floats, in lists too."""
    if isinstance(value, list):
        return [_as_float(part) for part in value]
    return float(value) if isinstance(value, int) and not isinstance(value, bool) else value


def _checked(values: JsonObject, max_balls: int) -> JsonObject:
    ranges = {
        "balls": BALLS, "width": SIDE, "height": SIDE, "speed": SPEED, **SETTINGS,
        **{name: BALL[name] for name in ("density", "restitution", "friction")},
    }  # fmt: skip
    plain = {name: value for name, value in values.items() if name in ranges}
    found: dict[str, Any] = checked(plain, ranges)
    if found["balls"] > max_balls:
        raise InvalidValueError(
            f"balls {found['balls']}: a room can have at most {max_balls}", field="balls"
        )
    found["seed"] = str(parse_seed(values["seed"]))
    if "radii" in values:
        found["radii"] = _radii(values["radii"])
        _check_room(found)
    return found


def _radii(value: object) -> list[float]:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise InvalidValueError(
            f"radii {shorten(value)} is not a list of two radii, the smaller first", field="radii"
        )
    low, high = (BALL["radius"].check(radius, "radii") for radius in value)
    if low > high:
        raise InvalidValueError(
            f"radii {shorten(value)}: the smaller must come first", field="radii"
        )
    return [low, high]


def _check_room(values: JsonObject) -> None:
    """Raise InvalidValueError if the balls do not fit into the sandbox side by side."""
    side = 2.0 * values["radii"][1]
    columns, rows = int(values["width"] / side), int(values["height"] / side)
    if values["balls"] > columns * rows:
        raise InvalidValueError(
            f"{values['balls']} balls of up to {values['radii'][1]:g} m do not fit into "
            f"{values['width']:g} m by {values['height']:g} m: at most {columns * rows} do",
            field="balls",
        )
