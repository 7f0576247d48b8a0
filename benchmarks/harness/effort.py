"""The options of a run: its sizes, its rounds, and where it reports progress."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path


class MissingError(Exception):
    """A benchmark lacks something that it needs; the message names it."""


def _silent(label: str) -> None:
    """Ignore the progress."""


@dataclass(frozen=True)
class Effort:
    """The options of one run.

    quick: small sizes, only to see that everything works. rounds: runs of each timed job, at least
    1. long: 10^7 random drops in the stability benchmark, which take hours. node: also measure
    engines for Node.js. findings: the folder for faulty drops; None: they are not saved. cluster:
    the workers that compute the random drops, see `plinko.engine.batches.workers`. step(label) is
    called after each step of the work.
    """

    quick: bool = False
    rounds: int = 3
    long: bool = False
    node: bool = True
    findings: Path | None = None
    cluster: str | None = None
    step: Callable[[str], None] = _silent

    def size(self, full: int, quick: int) -> int:
        """`quick` in a quick run, `full` otherwise."""
        return quick if self.quick else full

    def telling(self, step: Callable[[str], None]) -> "Effort":
        """A copy that reports its progress to `step`."""
        return replace(self, step=step)
