"""Error against cost, from fixed steps to proven digits: the photon, and drops on a board.

A certified result needs no reference: its error is the radius of the enclosure.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from statistics import median

import numpy as np
from flint import arb

from benchmarks.harness.clock import seconds_of
from benchmarks.harness.effort import Effort
from benchmarks.literature import photon, siam
from benchmarks.scenes import boards
from plinko.engine import Board, drop
from plinko.engine.certified.balls import precision
from plinko.engine.certified.certify import Effort as ProofEffort
from plinko.engine.certified.certify import prove
from plinko.engine.certified.flight import Flight, State
from plinko.engine.certified.scene import scene_of
from plinko.engine.constants import KIND_PEG, KIND_WALL

BITS = (64, 80, 96, 128, 160, 192, 256)
RATES = (60, 240, 960, 3840)
"""Steps per second; each step has four substeps."""

IMPACT = 8
"""Positions are compared midway between this impact and the next."""


@dataclass(frozen=True)
class Point:
    """Time in s and error in m of one method; medians if there are several drops."""

    way: str
    label: str
    seconds: float
    error: float


def of_the_photon(effort: Effort) -> list[Point]:
    """The photon in double precision, and certified at rising precision."""
    siam.in_double_precision()
    double = siam.in_double_precision()
    cost = _least(siam.in_double_precision, effort)
    points = [Point("double", "double precision", cost, double.error)]
    for bits in BITS:
        found = photon.with_bits(bits, 10)
        if found is not None:
            cost = _least(partial(photon.with_bits, bits, 10), effort)
            points.append(Point("certified", f"{bits} bits", cost, found.error))
        effort.step("digits")
    return points


def of_drops(effort: Effort) -> list[Point]:
    """Drops on twelve rows without drag and friction, by all three methods."""
    board = boards.triangle(12, boards.PLAIN)
    zone = board.drop
    count = effort.size(12, 3)
    xs = np.random.default_rng(4).uniform(zone.x - zone.jitter, zone.x + zone.jitter, count)
    truths = [_Truth.of(board, x) for x in xs.tolist()]
    points = [_stepped(board, rate, truths, effort) for rate in RATES[: effort.size(len(RATES), 2)]]
    points.append(_double(board, truths, effort))
    points += [_certified(board, bits, truths, effort) for bits in BITS]
    return [point for point in points if math.isfinite(point.error)]


@dataclass(frozen=True)
class _Truth:
    """A ball's position, known to at least 50 digits, at a given time."""

    x_start: float
    time: float
    x: float
    y: float

    @classmethod
    def of(cls, board: Board, x: float) -> "_Truth":
        hits = drop(board, x=x).impacts
        hits = hits[np.isin(hits["kind"], (KIND_PEG, KIND_WALL))]
        time = 0.5 * float(hits["t"][IMPACT - 1] + hits["t"][IMPACT])
        place = _enclosed(board, x, time, 512)
        assert place is not None
        return cls(x, time, float(place.x), float(place.y))

    def off(self, state: np.void) -> float:
        """Distance of a state from the true position, m."""
        return math.hypot(float(state["x"]) - self.x, float(state["y"]) - self.y)


Play = Callable[[_Truth], float]
"""Plays a drop and returns its position error, m."""


def _enclosed(board: Board, x: float, time: float, bits: int) -> State | None:
    """The ball's enclosure at `time` with `bits` of precision; None if it cannot be decided."""
    path = prove(board, Fraction(x), effort=ProofEffort(first_bits=bits, most_bits=bits)).path
    if path is None:
        return None
    with precision(bits):
        before = [event.state for event in path.events if event.state.t < time][-1]
        return Flight(scene_of(board, bits), before).at(arb(time) - before.t)


def _stepped(board: Board, rate: int, truths: list[_Truth], effort: Effort) -> Point:
    def play(truth: _Truth) -> float:
        played = drop(board, x=truth.x_start, solver="stepped", dt=1.0 / rate)
        return truth.off(played.states([truth.time])[0])

    return _point("stepped", f"dt 1/{rate} s", play, truths, effort)


def _double(board: Board, truths: list[_Truth], effort: Effort) -> Point:
    def play(truth: _Truth) -> float:
        return truth.off(drop(board, x=truth.x_start).states([truth.time])[0])

    return _point("double", "double precision", play, truths, effort)


def _certified(board: Board, bits: int, truths: list[_Truth], effort: Effort) -> Point:
    def play(truth: _Truth) -> float:
        place = _enclosed(board, truth.x_start, truth.time, bits)
        return (
            math.inf if place is None else float((place.x.rad() ** 2 + place.y.rad() ** 2).sqrt())
        )

    return _point("certified", f"{bits} bits", play, truths, effort)


def _point(way: str, label: str, play: Play, truths: list[_Truth], effort: Effort) -> Point:
    errors = [play(truth) for truth in truths]
    costs = [_least(partial(play, truth), effort) for truth in truths]
    effort.step("digits")
    return Point(way, label, median(costs), median(errors))


def _least(work: Callable[[], object], effort: Effort) -> float:
    """Processor seconds of the fastest of several runs."""
    return min(seconds_of(work, time.thread_time) for _ in range(effort.size(5, 2)))
