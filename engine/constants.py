"""Numbers the whole engine agrees on, each with its unit and what changes with it."""

from typing import Final

PHYSICS_VERSION: Final = 5
"""Raised whenever any drop's bits change; part of every digest."""

MAX_TIME: Final = 1000.0
"""Seconds of one drop: a ball that has not landed by then ends without a bin."""

EARTH_GRAVITY: Final = 9.81
"""m/s^2, at sea level and 45 degrees latitude."""

# What an impact record is about. The numbers are part of every digest.
KIND_PEG: Final = 0
KIND_WALL: Final = 1
KIND_CONTACT_BEGIN: Final = 2
KIND_CONTACT_CHANGE: Final = 3
KIND_CONTACT_END: Final = 4
KIND_LANDING: Final = 5
KIND_BALL: Final = 6  # another ball, where balls touch each other; in no drop's record

KIND_NAMES: Final = ("peg", "wall", "contact begins", "contact changes", "contact ends", "landing")
