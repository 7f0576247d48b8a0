"""Where work is computed: in this process, or by the workers of a cluster. One interface for both.

Work is a function of a module, or `functools.partial` of one, with values for arguments: it may be
computed anywhere, again, and in any order.
"""

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Protocol, TypeVar

from engine.drops.threads import thread_count
from engine.errors import ParameterError

A = TypeVar("A")
R = TypeVar("R")


class Workers(Protocol):
    """Compute calls; as many side by side as `at_once` says."""

    @property
    def at_once(self) -> int:
        """Calls that are computed at the same time."""

    def compute(self, work: Callable[[A, int], R], asked: Iterable[A]) -> Iterator[tuple[A, R]]:
        """Each of `asked` with work(each, threads), as they become ready; `asked` is read lazily.

        threads: how many the call may use. What `work` raises is raised here. Who stops iterating
        ends what is under way.
        """


@dataclass(frozen=True, slots=True)
class Here:
    """One call after the other in this process, each on so many threads (default: every core)."""

    threads: int | None = None

    @property
    def at_once(self) -> int:
        """One, which has all threads."""
        return 1

    def compute(self, work: Callable[[A, int], R], asked: Iterable[A]) -> Iterator[tuple[A, R]]:
        """Each of `asked` with what `work` makes of it, in order."""
        threads = thread_count(self.threads)
        for each in asked:
            yield each, work(each, threads)


def workers_at(cluster: str | None, threads: int | None = None) -> AbstractContextManager[Workers]:
    """The workers of a cluster, or for None this process with so many threads.

    `local:N` starts N processes on this machine (`local`: one a core), `tcp://host:8786` is a Dask
    scheduler's address. Raises ParameterError for any other, and ClusterError where no work can be
    computed: nobody answers, there are no workers, or they have other physics or kernels.
    """
    if cluster is None:
        return nullcontext(Here(threads))
    if threads is not None:
        raise ParameterError(
            f"threads {threads} belong to this process: with a cluster, say local:{threads}",
            field="threads",
        )
    # Dask is imported by whoever asks for it: it takes a second, and may not be installed.
    opened: Any = import_module("engine.batches.cluster").opened
    workers: AbstractContextManager[Workers] = opened(cluster)
    return workers
