"""The numbers a step is computed with."""

from typing import NamedTuple


class SolverSettings(NamedTuple):
    """`ArenaSettings` as the kernels take them; SI."""

    gravity: float
    drag: float
    damping: float  # of the velocity, per step
    correction: float
    h: float  # a substep, s
    substeps: int
    max_speed: float  # infinite: no clamp
    sleep_steps: int  # steps of stillness before a ball may sleep; 0: never
