"""The elastic Galton board: a point falls without end through a lattice of discs, with no loss.

Only gravity speeds it up, and the faster it is, the more often it is scattered. Its speed grows as
t^(1/3), its depth as t^(2/3), and it returns upwards again and again (Chernov and Dolgopyat).
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from benchmarks.billiards import Billiard, launch
from benchmarks.harness.effort import Effort
from benchmarks.literature import lorentz
from benchmarks.literature.finding import Estimate

GAP = 0.2
GRAVITY = 1.0
PARTS = 20
"""Groups of balls, each fitted separately: the spread of the fits is the exponents' error."""

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class GaltonBoard:
    """The results. times, shape (m,); depths and speeds, shape (m, n).

    A depth is measured from the height at which the ball would be at rest, v^2 / 2g = 0.5 above its
    start.
    """

    times: Floats
    depths: Floats
    speeds: Floats
    impacts: int
    speed_exponent: Estimate
    depth_exponent: Estimate
    energy_drift: float
    returned: float
    """Share of the balls that, after a hundredth of the time, rose above half of their depth."""


def board() -> Billiard:
    """The Lorentz gas with the gap GAP, and gravity."""
    gas = lorentz.billiard(GAP)
    return Billiard(pegs=gas.pegs, ball=gas.ball, cell=gas.cell, gravity=GRAVITY)


def measure(balls: int, longest: float, effort: Effort) -> GaltonBoard:
    """Follow `balls` points that start with speed 1 until `longest`, sampled at 61 times.

    Exponents are fitted over the last two decades of time.
    """
    galton = board()
    flow = launch(galton, *lorentz.starts(galton, balls, seed=2))
    top = flow.places[:, 1] - 0.5 / GRAVITY
    times = np.geomspace(1.0, longest, 61)
    depths, speeds = [], []
    for time in times.tolist():
        flow = flow.until(time)
        depths.append(flow.places[:, 1] - top)
        speeds.append(np.linalg.norm(flow.velocities, axis=1))
        effort.step("Galton board")
    if flow.stopped:
        raise RuntimeError(f"balls of the Galton board stopped: {flow.stopped}")
    depth, speed = np.array(depths), np.array(speeds)
    late = times >= 0.01 * longest
    energy = 0.5 * speed**2 - GRAVITY * depth
    deepest = np.maximum.accumulate(depth[late], axis=0)
    return GaltonBoard(
        times=times,
        depths=depth,
        speeds=speed,
        impacts=int(flow.impacts.sum()),
        speed_exponent=_exponent(times[late], speed[late]),
        depth_exponent=_exponent(times[late], depth[late]),
        energy_drift=float(np.abs(energy).max() / (0.5 * speed**2).max()),
        returned=float((depth[late] < 0.5 * deepest).any(axis=0).mean()),
    )


def _exponent(times: Floats, values: Floats) -> Estimate:
    """Slope of the log of the mean against log time, fitted for each of PARTS groups of balls."""
    groups = np.array_split(values, PARTS, axis=1)
    log = np.log(times)
    slopes = [np.polyfit(log, np.log(group.mean(axis=1)), 1)[0] for group in groups]
    return Estimate.of(np.array(slopes))
