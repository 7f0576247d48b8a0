"""Constants of the whole engine, each with its unit and what depends on it."""

from typing import Final

PHYSICS_VERSION: Final = 6
"""Increased with every change of any drop's bits; part of every digest."""

MAX_TIME: Final = 1000.0
"""s. A ball that has not landed after this time ends its drop without a bin."""

EARTH_GRAVITY: Final = 9.81
"""m/s^2, at sea level and 45 degrees latitude."""

# Kinds of events. The numbers are part of every digest.
KIND_PEG: Final = 0
KIND_WALL: Final = 1
KIND_CONTACT_BEGIN: Final = 2
KIND_CONTACT_CHANGE: Final = 3
KIND_CONTACT_END: Final = 4
KIND_LANDING: Final = 5
KIND_BALL: Final = 6  # another ball, if balls touch each other; not in records of drops

KIND_NAMES: Final = ("peg", "wall", "contact begins", "contact changes", "contact ends", "landing")
