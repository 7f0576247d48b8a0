"""How a drop can end, and in words why one did not land."""

FLYING = -1  # not yet
LANDED = 0
WEDGED = 1
BALANCED = 2
ESCAPED = 3
EVENT_LIMIT = 4
TIME_LIMIT = 5

REASONS = (
    "",
    "wedged: at rest between two surfaces",
    "balanced: at rest on a surface",
    "escaped: too far from the board",
    "event limit: no end in sight after the allowed number of events",
    "time limit: no end in sight after the allowed time",
)

MAX_EVENTS = 100_000
"""Events in one drop. On the presets it has tens; only a ball that bounces for ever has more."""

MAX_TIME = 1000.0
"""Seconds of one drop."""
