"""Names, units and ranges of all values that a client may send to touching balls."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from plinko.app.errors import InvalidValueError
from plinko.engine.errors import shorten
from plinko.engine.multibody.scenes import GRAVITY_PRESETS, RESTITUTION_PRESETS
from plinko.engine.multibody.settings import ArenaSettings


@dataclass(frozen=True, slots=True)
class Range:
    """Least and greatest value of a field, in `unit`, and its default."""

    low: float
    high: float
    unit: str
    default: float | None = None
    whole: bool = False

    def check(self, value: object, field: str) -> float:
        """The value as a number in this range; raises InvalidValueError."""
        number = _number(value, field)
        if self.whole and number != int(number):
            raise InvalidValueError(f"{field} {shorten(value)} is not a whole number", field=field)
        if not self.low <= number <= self.high:
            unit = f" {self.unit}" if self.unit else ""
            raise InvalidValueError(
                f"{field} {shorten(value)} is not from {self.low:g} to {self.high:g}{unit}",
                field=field,
            )
        return int(number) if self.whole else number


BALL: Final = {
    "radius": Range(0.01, 0.5, "m", 0.12),
    "density": Range(0.01, 100_000.0, "kg/m²", 80.0),
    "restitution": Range(0.0, 1.0, "", 0.9),
    "friction": Range(0.0, 10.0, "", 0.2),
}
"""Size and material of a ball. Density is mass per area."""

MOTION: Final = {
    "x": Range(-1000.0, 1000.0, "m"),
    "y": Range(-1000.0, 1000.0, "m"),
    "vx": Range(-100.0, 100.0, "m/s", 0.0),
    "vy": Range(-100.0, 100.0, "m/s", 0.0),
    "omega": Range(-1000.0, 1000.0, "rad/s", 0.0),
}

SETTINGS: Final = {
    "gravity": Range(-100.0, 100.0, "m/s²", 9.81),
    "gravity_x": Range(-100.0, 100.0, "m/s²", 0.0),
    "drag": Range(0.0, 100.0, "1/s", 0.0),
    "damping": Range(0.90, 1.0, "", 1.0),
    "rolling": Range(0.0, 1.0, "", 0.001),
    "max_speed": Range(0.0, 1000.0, "m/s", 0.0),
    "correction": Range(0.4, 0.8, "", 0.6),
    "dt": Range(0.001, 0.1, "s", 1.0 / 60.0),
    "substeps": Range(1, 32, "", 4, whole=True),
    "projection": Range(0, 1, "", 1, whole=True),
    "cell": Range(0.0, 10.0, "m", 0.0),
}
"""Settings of a whole room, as in ArenaSettings. A max_speed of 0 is no limit, a cell of 0 one that
is chosen by the balls' sizes, a projection of 0 none."""

SINCE_2: Final = ("gravity_x", "rolling", "max_speed", "projection", "cell")
"""Settings that earlier releases did not have. A scene has those that differ from the default, so
that earlier scenes keep their digests."""

PRESETS: Final = {"gravity": GRAVITY_PRESETS, "restitution": RESTITUTION_PRESETS}

MOST_WORK: Final = 16_000
"""Balls times substeps in one tick: what a server can compute for one room among others."""


def named(value: object, field: str) -> object:
    """Replace a preset's name by its number; returns any other value unchanged.

    Raises InvalidValueError for an unknown name.
    """
    presets = PRESETS.get(field)
    if presets is None or not isinstance(value, str):
        return value
    if value not in presets:
        known = ", ".join(presets)
        raise InvalidValueError(
            f"{field} {shorten(value)} is neither a number nor one of: {known}", field=field
        )
    return presets[value]


def checked(
    values: Mapping[str, object], *tables: Mapping[str, Range], prefix: str = ""
) -> dict[str, float]:
    """The values that are not None, as numbers within their ranges, by name."""
    ranges = {name: entry for table in tables for name, entry in table.items()}
    return {
        name: ranges[name].check(named(value, name), prefix + name)
        for name, value in values.items()
        if value is not None
    }


def check_work(balls: int, dt: float, substeps: float, tick_rate: int) -> None:
    """Raise InvalidValueError if a tick of the room would take more than MOST_WORK."""
    steps = substeps / (dt * tick_rate)
    if balls * steps > MOST_WORK:
        raise InvalidValueError(
            f"{balls} balls in {steps:.1f} substeps a tick are {balls * steps:.0f} steps, more "
            f"than {MOST_WORK}: take a longer dt, fewer substeps or fewer balls",
            field="dt",
        )


def for_arena(settings: Mapping[str, float]) -> dict[str, Any]:
    """Settings of a room as those of its arena."""
    found: dict[str, Any] = dict(settings)
    for name in ("max_speed", "cell"):
        if name in found:
            found[name] = found[name] or None
    if "projection" in found:
        found["projection"] = bool(found["projection"])
    return found


def of_arena(settings: ArenaSettings) -> dict[str, float]:
    """The settings of an arena as those of its room."""
    found = {name: getattr(settings, name) or 0 for name in SETTINGS}
    return found | {"projection": int(settings.projection)}


def table(**usual: float) -> dict[str, dict[str, dict[str, object]]]:
    """All ranges, for a page's sliders; `usual` has the room's own defaults of a ball."""
    return {
        group: {
            name: {
                "low": entry.low,
                "high": entry.high,
                "unit": entry.unit,
                "default": usual.get(name, entry.default) if group == "ball" else entry.default,
            }
            for name, entry in ranges.items()
        }
        for group, ranges in (("ball", BALL), ("settings", SETTINGS))
    }


def number_of(value: object, field: str) -> float:
    """A field's value in a log, as `checked` has made it; raises InvalidValueError."""
    number = _number(value, field)
    return int(number) if field in SETTINGS and SETTINGS[field].whole else number


def _number(value: object, field: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InvalidValueError(f"{field} {shorten(value)} is not a number", field=field)
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise InvalidValueError(f"{field} {shorten(value)} is not a finite number", field=field)
    return number + 0.0  # turns -0.0 into 0.0: JavaScript writes both without a sign
