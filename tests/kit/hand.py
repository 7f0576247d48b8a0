"""A clock that a test moves by hand, for the ticks of rooms and for the times in the ledger."""

from typing import Final

_BEGIN: Final = 1e9  # Unix time of tick 0
RATE: Final = 60  # ticks a second


class HandClock:
    """The clock of a runner, in s. Its `unix` time moves with the ticks only, a tick at a time."""

    def __init__(self) -> None:
        self.ticks = 0
        self.time = 0.0  # in addition to the ticks

    def __call__(self) -> float:
        return self.ticks / RATE + self.time

    def unix(self) -> float:
        """Unix time in s, in the middle of a tick."""
        return _BEGIN + (self.ticks + 0.5) / RATE

    def tick(self, ticks: int = 1) -> None:
        self.ticks += ticks
