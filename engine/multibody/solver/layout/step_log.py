"""The log of a step: impacts, landings and their numbers."""

from typing import NamedTuple

from plinko.engine.multibody.solver.layout.array_types import Counts, Floats, Ints

# Columns of `StepLog.floats`.
T = 0  # s since the start of the step
X = 1  # of ball a's centre, m
Y = 2
SPEED = 3  # of the approach, along the normal, m/s

# Columns of `StepLog.ints`.
A = 0  # id of a ball
B = 1  # id of the other ball, or -1 - item

# Rows of `StepLog.counts`.
TOUCHES = 0
LANDINGS = 1
DEPARTURES = 2  # balls that went beyond FARTHEST
AWAKE_BEFORE = 3  # balls awake when the step began
COUNTS = 4


class StepLog(NamedTuple):
    """Impacts and landings of a step; those without room are counted but not logged."""

    floats: Floats  # (m, 4)
    ints: Ints  # (m, 2)
    landings: Floats  # (k, 2): t since the start of the step in s, x in m
    landed: Ints  # (k,): ids
    counts: Counts  # (4,)
