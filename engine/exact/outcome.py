"""The outcomes of drops, the reasons why a ball did not land, and the results of many drops."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from plinko.engine.physics.array_types import Floats, Ints

RUNNING = -1  # not yet
LANDED = 0
WEDGED = 1
BALANCED = 2
ESCAPED = 3
# Limits of the computation; the ball itself is still moving.
EVENT_LIMIT = 4
TIME_LIMIT = 5
SEARCH_LIMIT = 6
IMPULSE_LIMIT = 7
# An error of the solver, found by its own check (`free_flight.TRUE_WITHIN`).
FALSE_PATH = 8

PHASE_ENDS = 100
"""Codes from here on end a phase of a drop, but not the drop; each phase names its own."""

REASONS = (
    "",
    "wedged: at rest between two surfaces",
    "balanced: at rest on a surface",
    "escaped: too far from the board",
    "event budget: still moving after 100,000 events",
    "time budget: still moving after 1,000 s",
    "search budget: nothing hit within a million search windows of one flight",
    "impulse budget: still bouncing between two surfaces after 1,000 impulses at one time",
    "solver error: the computed path left its surface or gained energy",
)

MAX_EVENTS = 100_000
"""Events of one drop, at most. On the presets a drop has tens; only a ball that bounces for ever
reaches this."""


class Results(NamedTuple):
    """The results of n drops, as columns of shape (n,)."""

    bins: npt.NDArray[np.int32]  # -1: it did not land
    durations: Floats  # s
    x_ends: Floats  # m
    impacts: npt.NDArray[np.int32]
    outcomes: npt.NDArray[np.int8]

    def at(self, rows: slice | Ints) -> "Results":
        """The results of some drops: views for a slice, copies for indices."""
        return Results(
            self.bins[rows],
            self.durations[rows],
            self.x_ends[rows],
            self.impacts[rows],
            self.outcomes[rows],
        )


def new_results(count: int) -> Results:
    """Uninitialized results of `count` drops."""
    return Results(
        bins=np.empty(count, np.int32),
        durations=np.empty(count),
        x_ends=np.empty(count),
        impacts=np.empty(count, np.int32),
        outcomes=np.empty(count, np.int8),
    )
