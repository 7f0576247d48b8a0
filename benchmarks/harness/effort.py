"""How thorough a run is, and whom it tells how far it has come."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path


class MissingError(Exception):
    """Something a benchmark cannot do without is not there; the message says what."""


def _silent(label: str) -> None:
    """Progress that nobody watches."""


@dataclass(frozen=True)
class Effort:
    """quick: small sizes, to see that all works. rounds: repeats of each timed job, at least 1.

    long: 10^7 random drops in the stability benchmark, which takes hours. node: engines for
    Node.js too. findings: where faults are saved, if anywhere. cluster: who computes the
    random drops, see `engine.batches.workers`. step(label) is called at each piece
    of work done.
    """

    quick: bool = False
    rounds: int = 3
    long: bool = False
    node: bool = True
    findings: Path | None = None
    cluster: str | None = None
    step: Callable[[str], None] = _silent

    def size(self, full: int, quick: int) -> int:
        """The size of something in this run."""
        return quick if self.quick else full

    def telling(self, step: Callable[[str], None]) -> "Effort":
        """The same, with its progress told to `step`."""
        return replace(self, step=step)
