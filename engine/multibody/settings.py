"""The settings of an arena: frozen, checked once, each with its unit and range."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf, sqrt
from typing import Any, Final, Literal

from plinko.engine.errors import ParameterError, shorten
from plinko.engine.multibody.solver.layout.solver_settings import SolverSettings
from plinko.engine.parameters import (
    DEFAULT_CORRECTION,
    DEFAULT_DT,
    DEFAULT_SUBSTEPS,
    Stepped,
    number,
)

SLEEP_SECONDS = 0.5
"""How long an island must be still before it falls asleep."""

_RANGES: Final[Mapping[str, tuple[float, float]]] = {
    "gravity": (-1e6, 1e6),
    "gravity_x": (-1e6, 1e6),
    "drag": (0.0, 1e6),
    "damping": (0.9, 1.0),
    "rolling": (0.0, 1.0),
    "correction": (0.4, 0.8),
    "dt": (1e-6, 0.1),
    "max_speed": (1e-9, 1e9),
    "cell": (1e-3, 1e6),
}
_OPTIONAL: Final = frozenset({"max_speed", "cell"})


@dataclass(frozen=True, slots=True, kw_only=True)
class ArenaSettings:
    """The settings of an arena. Raises ParameterError for an invalid value.

    gravity, gravity_x: m/s^2, downward and to the right; negative values point up and left. drag:
    1/s. damping: factor of the velocity in each step. rolling: coefficient of rolling resistance.
    pair_restitution: whether two bodies rebound with the "greater" of their restitutions, or with
    the "lesser", as clay does on steel. dt: duration of a step, s. max_speed: m/s, None for no
    limit. sleeping: whether islands at rest fall asleep. cell: size of the smallest cells of the
    broad phase in m, None to choose it by the balls' sizes; it may change the order of contacts.

    correction: fraction of an overlap that a substep removes, by at most a quarter of a ball's
    radius. projection: whether the end of each step removes what is left above 0.8 % of the smaller
    radius.
    """

    gravity: float = 9.81
    gravity_x: float = 0.0
    drag: float = 0.0
    damping: float = 1.0
    rolling: float = 0.001
    pair_restitution: Literal["greater", "lesser"] = "greater"
    correction: float = DEFAULT_CORRECTION
    projection: bool = True
    dt: float = DEFAULT_DT
    substeps: int = DEFAULT_SUBSTEPS
    max_speed: float | None = None
    sleeping: bool = True
    cell: float | None = None

    def __post_init__(self) -> None:
        Stepped(self.dt, self.substeps, self.correction)
        for name, (low, high) in _RANGES.items():
            value = getattr(self, name)
            if value is not None or name not in _OPTIONAL:
                object.__setattr__(self, name, number(value, name, low, high))
        for name in ("sleeping", "projection"):
            if not isinstance(getattr(self, name), bool):
                raise ParameterError(
                    f"{name} is {shorten(getattr(self, name))}: it must be true or false",
                    field=name,
                )
        rule: object = self.pair_restitution
        if not (isinstance(rule, str) and rule in ("greater", "lesser")):
            raise ParameterError(
                f"pair_restitution {shorten(rule)} is neither 'greater' nor 'lesser'",
                field="pair_restitution",
            )

    def changed(self, values: Mapping[str, Any]) -> "ArenaSettings":
        """A copy with some other values; ParameterError for an unknown name."""
        for name in values:
            if name not in self.__slots__:
                raise ParameterError(
                    f"there is no setting {shorten(name)}: use {', '.join(self.__slots__)}",
                    field=name,
                )
        return replace(self, **values)

    def for_solver(self) -> SolverSettings:
        """The settings in the form that the kernels take."""
        still_steps = max(2, round(SLEEP_SECONDS / self.dt))
        return SolverSettings(
            gravity_x=self.gravity_x,
            gravity_y=self.gravity,
            gravity=sqrt(self.gravity_x * self.gravity_x + self.gravity * self.gravity),
            drag=self.drag,
            damping=self.damping,
            correction=self.correction,
            h=self.dt / self.substeps,
            substeps=self.substeps,
            max_speed=inf if self.max_speed is None else self.max_speed,
            sleep_steps=still_steps if self.sleeping else 0,
            rolling=self.rolling,
            lesser=self.pair_restitution == "lesser",
            projecting=self.projection,
            cell=0.0 if self.cell is None else self.cell,
        )

    def to_dict(self) -> dict[str, Any]:
        """The JSON form."""
        return {name: getattr(self, name) for name in self.__slots__}
