"""The settings of a step."""

from typing import NamedTuple


class SolverSettings(NamedTuple):
    """`ArenaSettings` in the form that the kernels take; SI units."""

    gravity: float
    drag: float
    damping: float  # factor of the velocity in each step
    correction: float
    h: float  # duration of a substep, s
    substeps: int
    max_speed: float  # infinite: no limit
    sleep_steps: int  # still steps before a ball may sleep; 0: never
