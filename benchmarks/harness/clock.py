"""Timing of contestants in turns, so that a busy machine slows all of them alike."""

import gc
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Sample:
    """Repeated measurements of one quantity."""

    values: tuple[float, ...]

    @property
    def median(self) -> float:
        return statistics.median(self.values)

    @property
    def low(self) -> float:
        return min(self.values)

    @property
    def high(self) -> float:
        return max(self.values)

    def map(self, function: Callable[[float], float]) -> "Sample":
        """The same sample in another unit."""
        return Sample(tuple(function(value) for value in self.values))

    def over(self, other: "Sample") -> "Sample":
        """Ratios to `other`, round by round, so that a load that slows both cancels."""
        return Sample(tuple(a / b for a, b in zip(self.values, other.values, strict=True)))

    def to_dict(self) -> dict[str, float | list[float]]:
        return {"median": self.median, "values": list(self.values)}


def seconds_of(work: Callable[[], object], clock: Callable[[], float] = time.perf_counter) -> float:
    """Seconds that one call takes by `clock`, with garbage collection off.

    The default clock gives wall time, `time.process_time` the processor time of all threads.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        start = clock()
        work()
        return clock() - start
    finally:
        if was_on:
            gc.enable()


Job = Callable[[], float]
"""Does its work once and returns one figure, usually the seconds it took."""


def timed(work: Callable[[], object]) -> Job:
    """A job that returns the wall seconds of `work`."""
    return lambda: seconds_of(work)


def in_turns(
    jobs: Mapping[str, Job], rounds: int, tick: Callable[[], None] | None = None
) -> dict[str, Sample]:
    """Run each job once per round and return a sample per job; each round starts at another job.

    The first round is not counted: it warms caches and branch predictors.
    """
    names = list(jobs)
    found: dict[str, list[float]] = {name: [] for name in names}
    for turn in range(rounds + 1):
        for name in _rotated(names, turn):
            value = jobs[name]()
            if turn > 0:
                found[name].append(value)
        if tick:
            tick()
    return {name: Sample(tuple(values)) for name, values in found.items()}


def _rotated(names: Sequence[str], turn: int) -> list[str]:
    first = turn % len(names) if names else 0
    return [*names[first:], *names[:first]]
