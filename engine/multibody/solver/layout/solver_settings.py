"""The settings of a step."""

from typing import NamedTuple


class SolverSettings(NamedTuple):
    """`ArenaSettings` in the form that the kernels take; SI units."""

    gravity_x: float
    gravity_y: float
    gravity: float  # its magnitude
    drag: float
    damping: float  # factor of the velocity in each step
    correction: float
    h: float  # duration of a substep, s
    substeps: int
    max_speed: float  # infinite: no limit
    sleep_steps: int  # still steps before a ball may sleep; 0: never
    rolling: float  # coefficient of rolling resistance
    lesser: bool  # whether a pair has the lesser restitution of its two, instead of the greater
    projecting: bool  # whether visible overlap is removed at the end of a step
    cell: float  # size of the smallest cells of the broad phase, m; 0: chosen by the discs' sizes
