"""The triangular Lorentz gas: mean free path, diffusion and Lyapunov exponent.

A point moves among discs of radius 1 on a triangular lattice with the spacing d = 2 + w. For
0 < w < 4 / sqrt(3) - 2 every straight line hits a disc, and the point diffuses.
"""

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np
import numpy.typing as npt

from benchmarks.billiards import Billiard, Flow, launch
from benchmarks.harness.effort import Effort
from benchmarks.literature.finding import Estimate
from plinko.engine.board.parts import BallSpec, Peg

GAPS = (0.1, 0.2, sqrt(5.0) - 2.0, 0.3)
"""Values of w. The third is the golden mean's, with a spacing of sqrt(5)."""

LYAPUNOV = {0.1: (2.6709, 8e-4), 0.2: (2.1041, 7e-4), GAPS[2]: (1.9634, 7e-4), 0.3: (1.7605, 7e-4)}
"""By gap: the exponent found by an independent program, and its standard error."""

SPAN = 20.0
"""Time between two samples: five times the mean stay in one cell at w = 0.1, where stays are
longest, so that successive displacements are no longer correlated."""

WARM_UP = 20.0
"""Time in which a tangent turns into the growing direction."""

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class LorentzGas:
    """The results at one gap; lengths in radii of a disc, times at speed 1."""

    gap: float
    impacts: int
    path: Estimate
    diffusion: Estimate
    lyapunov: Estimate
    speed_drift: float


def billiard(gap: float) -> Billiard:
    """One disc and its lattice. The peg and the ball have half of the radius each, so that the
    ball's centre moves like the point."""
    d = 2.0 + gap
    return Billiard(
        pegs=(Peg(0.0, 0.0, 0.5),),
        ball=BallSpec(radius=0.5, restitution=1.0),
        cell=((d, 0.0), (0.5 * d, 0.5 * sqrt(3.0) * d)),
    )


def mean_free_path(gap: float) -> float:
    """pi times the free area of a cell over the disc's circumference."""
    d = 2.0 + gap
    return (sqrt(3.0) * d * d / 2.0 - pi) / 2.0


def machta_zwanzig(gap: float) -> float:
    """Diffusion coefficient of a memoryless walk between traps; exact in the limit w -> 0."""
    d = 2.0 + gap
    return gap * d * d / (pi * (sqrt(3.0) * d * d - 2.0 * pi))


def starts(gas: Billiard, count: int, seed: int) -> tuple[Floats, Floats]:
    """Random positions in the free part of a cell, and random directions, both uniform.

    The flow preserves this distribution, so the start does not bias time averages.
    """
    assert gas.cell is not None
    rng = np.random.default_rng(seed)
    cell = np.array(gas.cell)
    places = np.zeros((0, 2))
    while len(places) < count:
        tried = rng.uniform(0.0, 1.0, (2 * count, 2)) @ cell
        corners = np.array([(0, 0), (1, 0), (0, 1), (1, 1)]) @ cell
        apart = np.linalg.norm(tried[:, None, :] - corners[None, :, :], axis=2)
        places = np.concatenate([places, tried[(apart > 1.0).all(axis=1)]])
    angle = rng.uniform(0.0, 2.0 * pi, count)
    return places[:count], np.stack([np.cos(angle), np.sin(angle)], axis=1)


def measure(gap: float, balls: int, looks: int, effort: Effort, seed: int = 1) -> LorentzGas:
    """Follow `balls` points over `looks` spans of SPAN, after a warm-up."""
    gas = billiard(gap)
    first = launch(gas, *starts(gas, balls, seed), tangents=True).until(WARM_UP)
    places, last = [first.places], first
    for look in range(looks):
        last = last.until(WARM_UP + SPAN * (look + 1))
        places.append(last.places)
        if look % 10 == 0:
            effort.step(f"Lorentz gas {gap:.3g}")
    time = SPAN * looks
    impacts = last.impacts - first.impacts
    speed = np.linalg.norm(last.velocities, axis=1)
    return LorentzGas(
        gap=gap,
        impacts=int(impacts.sum()),
        path=_ratio(time, impacts.astype(np.float64)),
        diffusion=_diffusion(np.array(places)),
        lyapunov=_lyapunov(first, last, time),
        speed_drift=float(np.abs(speed - 1.0).max()),
    )


def _ratio(time: float, impacts: Floats) -> Estimate:
    """Mean free path at speed 1: the time over the mean number of impacts."""
    mean = Estimate.of(impacts)
    return Estimate(time / mean.value, time * mean.error / mean.value**2)


def _diffusion(places: Floats) -> Estimate:
    """(<r^2> over two spans - <r^2> over one) / 4 SPAN.

    In the difference, the correlated first steps of a point cancel.
    """
    one = (np.diff(places, axis=0) ** 2).sum(axis=2).mean(axis=0)
    two = ((places[2:] - places[:-2]) ** 2).sum(axis=2).mean(axis=0)
    return Estimate.of((two - one) / (4.0 * SPAN))


def _lyapunov(first: Flow, last: Flow, time: float) -> Estimate:
    return Estimate.of((last.growth - first.growth) / time)
