"""What a client may ask of balls that touch each other: names, units and ranges of all values."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from app.errors import InvalidValueError, shorten
from engine.multibody.scenes import GRAVITY_PRESETS, RESTITUTION_PRESETS


@dataclass(frozen=True, slots=True)
class Range:
    """Least and greatest value, in `unit`; `default` is what a ball or a scene has unless told."""

    low: float
    high: float
    unit: str
    default: float | None = None
    whole: bool = False

    def check(self, value: object, field: str) -> float:
        """The value as a number of this range; raises InvalidValueError naming it."""
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
"""What a ball is made of. Density is mass per area."""

MOTION: Final = {
    "x": Range(-1000.0, 1000.0, "m"),
    "y": Range(-1000.0, 1000.0, "m"),
    "vx": Range(-100.0, 100.0, "m/s", 0.0),
    "vy": Range(-100.0, 100.0, "m/s", 0.0),
    "omega": Range(-1000.0, 1000.0, "rad/s", 0.0),
}

SETTINGS: Final = {
    "gravity": Range(0.0, 100.0, "m/s²", 9.81),
    "drag": Range(0.0, 100.0, "1/s", 0.0),
    "damping": Range(0.90, 1.0, "", 1.0),
    "correction": Range(0.4, 0.8, "", 0.6),
    "dt": Range(0.001, 0.1, "s", 1.0 / 60.0),
    "substeps": Range(1, 32, "", 4, whole=True),
}
"""What holds for a whole room. Damping is the share of the velocity kept in each step of dt."""

PRESETS: Final = {"gravity": GRAVITY_PRESETS, "restitution": RESTITUTION_PRESETS}

MOST_WORK: Final = 16_000
"""Balls times substeps in one tick: what a server can do for one room beside all others."""


def named(value: object, field: str) -> object:
    """A preset's value for its name, of the fields that have presets; else the value as it is.

    Raises InvalidValueError for a name that is none.
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
    """The given values (those not None) as numbers within their ranges, by name."""
    ranges = {name: entry for table in tables for name, entry in table.items()}
    return {
        name: ranges[name].check(named(value, name), prefix + name)
        for name, value in values.items()
        if value is not None
    }


def check_work(balls: int, dt: float, substeps: float, tick_rate: int) -> None:
    """Raise InvalidValueError when a tick of the room would take too many steps."""
    steps = substeps / (dt * tick_rate)
    if balls * steps > MOST_WORK:
        raise InvalidValueError(
            f"{balls} balls in {steps:.1f} substeps a tick are {balls * steps:.0f} steps, more "
            f"than {MOST_WORK}: take a longer dt, fewer substeps or fewer balls",
            field="dt",
        )


def table(**usual: float) -> dict[str, dict[str, dict[str, object]]]:
    """All ranges, for those who draw sliders; `usual` is what a ball has in this room, by name."""
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


def _number(value: object, field: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InvalidValueError(f"{field} {shorten(value)} is not a number", field=field)
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise InvalidValueError(f"{field} {shorten(value)} is not a finite number", field=field)
    return number + 0.0  # a negative zero, of which JavaScript writes no sign, is zero
