"""The two solvers that a caller can choose, with their parameters: frozen, checked once."""

import struct
from dataclasses import dataclass
from math import inf
from numbers import Real
from typing import Any, ClassVar, Final, Literal

from plinko.engine.errors import ParameterError, shorten

SolverName = Literal["exact", "stepped"]

DEFAULT_DT: Final = 1.0 / 60.0
DEFAULT_SUBSTEPS: Final = 4
DEFAULT_CORRECTION: Final = 0.6

MOST_STEPS: Final = 1_000_000
"""Most steps that one call advances: hours of play, and a request that ends."""


def number(value: object, field: str, low: float, high: float) -> float:
    """Return `value` as a float in [low, high]; ParameterError otherwise.

    Numbers of numpy, such as a float32, are accepted too.
    """
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ParameterError(f"{field} {shorten(value)} is not a number", field=field)
    try:
        found = float(value)
    except OverflowError:  # an integer of more than 308 digits
        value = found = inf if abs(value) == value else -inf
    if not low <= found <= high:  # a NaN fails this too
        raise ParameterError(
            f"{field} {shorten(value)} is not from {low:g} to {high:g}", field=field
        )
    return found


def frame_seconds(frame_time: object, dt: float) -> float:
    """Return `frame_time` in s; ParameterError if it takes more than MOST_STEPS steps of dt."""
    seconds = number(frame_time, "frame_time", 0.0, inf)
    if seconds > MOST_STEPS * dt:
        raise ParameterError(
            f"frame_time {seconds:g} s takes more than {MOST_STEPS} steps of {dt:g} s",
            field="frame_time",
        )
    return seconds


@dataclass(frozen=True, slots=True)
class Exact:
    """The event-driven solver, which has no parameters."""

    name: ClassVar[SolverName] = "exact"

    def encoded(self) -> bytes:
        """Bytes of the solver in a digest."""
        return b"\x00"

    def fields(self) -> dict[str, float]:
        """The solver's fields in a record, besides its name."""
        return {}


@dataclass(frozen=True, slots=True)
class Stepped:
    """The fixed-step solver. dt: step in s. substeps: per step.

    correction: fraction of an overlap that a substep removes.
    """

    dt: float = DEFAULT_DT
    substeps: int = DEFAULT_SUBSTEPS
    correction: float = DEFAULT_CORRECTION

    name: ClassVar[SolverName] = "stepped"

    def __post_init__(self) -> None:
        number(self.dt, "dt", 1e-6, 0.1)
        number(self.substeps, "substeps", 1, 1000)
        if not isinstance(self.substeps, int):
            raise ParameterError(
                f"substeps {self.substeps!r} is not a whole number", field="substeps"
            )
        number(self.correction, "correction", 0.4, 0.8)

    @property
    def h(self) -> float:
        """Duration of a substep, s."""
        return self.dt / self.substeps

    def encoded(self) -> bytes:
        """Bytes of the solver in a digest."""
        return b"\x01" + struct.pack("<dId", self.dt, self.substeps, self.correction)

    def fields(self) -> dict[str, float]:
        """The solver's fields in a record, besides its name."""
        return {"dt": self.dt, "substeps": self.substeps, "correction": self.correction}


Solver = Exact | Stepped


def make_solver(
    name: str,
    dt: float | None = None,
    substeps: int | None = None,
    correction: float | None = None,
) -> Solver:
    """Return the solver called `name`; None stands for the default of a parameter of `stepped`.

    Raises ParameterError for an invalid value, and for a parameter that the solver does not have.
    """
    fields = ("dt", dt), ("substeps", substeps), ("correction", correction)
    if name == "exact":
        for field, value in fields:
            if value is not None:
                raise ParameterError(
                    f"{field} {value!r} needs solver 'stepped': the exact solver has no time step",
                    field=field,
                )
        return Exact()
    if name == "stepped":
        given: dict[str, Any] = {field: value for field, value in fields if value is not None}
        return Stepped(**given)
    raise ParameterError(f"solver {name!r} is neither 'exact' nor 'stepped'", field="solver")
