"""How fast this machine can add and multiply: a lower bound for the time of an impact."""

from typing import Any

import numpy as np
import numpy.typing as npt
from numba import njit

from benchmarks.harness.clock import Job, seconds_of

Floats = npt.NDArray[np.float64]

LANES = 64
"""Independent numbers: enough to fill all vector lanes and to hide the latency of operations."""

DEPTH = 16
"""Operations per number between load and store, so that memory access does not matter."""

SWEEPS = 40_000


def _chain(x: Floats, a: float, b: float, sweeps: int) -> None:
    for _ in range(sweeps):
        for i in range(x.shape[0]):
            y = x[i]
            y = y * a + b
            y = y * a + b
            y = y * a + b
            y = y * a + b
            y = y * a + b
            y = y * a + b
            y = y * a + b
            y = y * a + b
            y = y * a + b
            y = y * a + b
            y = y * a + b
            y = y * a + b
            y = y * a + b
            y = y * a + b
            y = y * a + b
            y = y * a + b
            x[i] = y


def _divide(x: Floats, a: float, b: float, sweeps: int) -> None:
    for _ in range(sweeps):
        for i in range(x.shape[0]):
            x[i] = a / x[i]


def _root(x: Floats, a: float, b: float, sweeps: int) -> None:
    for _ in range(sweeps):
        for i in range(x.shape[0]):
            x[i] = np.sqrt(x[i])


def _serial(x: Floats, a: float, b: float, sweeps: int) -> None:
    y = x[0]
    for _ in range(sweeps):
        for _ in range(x.shape[0]):
            y = y * a + b
    x[0] = y


# Only `fused` may contract a * b + c into one operation; the engine must never do that.
_KERNELS: dict[str, tuple[Any, int]] = {
    "fused": (njit(fastmath={"contract"})(_chain), DEPTH),
    "separate": (njit(_chain), DEPTH),
    "divide": (njit(error_model="numpy")(_divide), 1),
    "root": (njit(_root), 1),
    "serial": (njit(_serial), 1),
}

MEANING = {
    "fused": "multiply-add, fused, independent",
    "separate": "multiply and add, not fused, independent",
    "divide": "division, independent",
    "root": "square root, independent",
    "serial": "multiply and add, each waiting for the one before",
}


def jobs(sweeps: int = SWEEPS) -> dict[str, Job]:
    """Jobs that return nanoseconds of one operation of each kind, on one core."""
    return {name: _job(name, sweeps) for name in _KERNELS}


def _job(name: str, sweeps: int) -> Job:
    kernel, depth = _KERNELS[name]
    x = np.full(LANES, 1.5)
    kernel(x, 0.5, 0.75, 1)  # compiles it; 1.5 is the fixed point of all these maps or near it

    def job() -> float:
        x[:] = 1.5
        seconds = seconds_of(lambda: kernel(x, 0.5, 0.75, sweeps))
        return seconds * 1e9 / (sweeps * LANES * depth)

    return job
