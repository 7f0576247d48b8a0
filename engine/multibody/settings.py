"""The settings of an arena: frozen, checked once, each with its unit and range."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf
from typing import Any

from plinko.engine.errors import ParameterError
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


@dataclass(frozen=True, slots=True, kw_only=True)
class ArenaSettings:
    """The settings of an arena. Raises ParameterError for an invalid value.

    gravity: m/s^2, downward. drag: 1/s. damping: factor of the velocity in each step. correction:
    fraction of an overlap that a substep removes. dt: duration of a step, s. max_speed: m/s, None
    for no limit. sleeping: whether islands at rest fall asleep.
    """

    gravity: float = 9.81
    drag: float = 0.0
    damping: float = 1.0
    correction: float = DEFAULT_CORRECTION
    dt: float = DEFAULT_DT
    substeps: int = DEFAULT_SUBSTEPS
    max_speed: float | None = None
    sleeping: bool = True

    def __post_init__(self) -> None:
        Stepped(self.dt, self.substeps, self.correction)
        for name, low, high in (("gravity", 0.0, 1e6), ("drag", 0.0, 1e6), ("damping", 0.9, 1.0)):
            object.__setattr__(self, name, number(getattr(self, name), name, low, high))
        object.__setattr__(self, "correction", float(self.correction))
        object.__setattr__(self, "dt", float(self.dt))
        if self.max_speed is not None:
            number(self.max_speed, "max_speed", 1e-9, 1e9)
        if not isinstance(self.sleeping, bool):
            raise ParameterError(
                f"sleeping is {self.sleeping!r}: it must be true or false", field="sleeping"
            )

    def changed(self, values: Mapping[str, Any]) -> "ArenaSettings":
        """A copy with some other values; ParameterError for an unknown name."""
        for name in values:
            if name not in self.__slots__:
                raise ParameterError(
                    f"there is no setting {name!r:.40}: use {', '.join(self.__slots__)}", field=name
                )
        return replace(self, **values)

    def for_solver(self) -> SolverSettings:
        """The settings in the form that the kernels take."""
        still_steps = max(2, round(SLEEP_SECONDS / self.dt))
        return SolverSettings(
            gravity=self.gravity,
            drag=self.drag,
            damping=self.damping,
            correction=self.correction,
            h=self.dt / self.substeps,
            substeps=self.substeps,
            max_speed=inf if self.max_speed is None else float(self.max_speed),
            sleep_steps=still_steps if self.sleeping else 0,
        )

    def to_dict(self) -> dict[str, Any]:
        """The JSON form."""
        return {name: getattr(self, name) for name in self.__slots__}
