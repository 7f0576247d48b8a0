"""One interface for computing in this process and by the workers of a cluster.

Work is a module's function, or `functools.partial` of one, whose arguments are plain values. So any
worker can compute it, in any order and more than once.
"""

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Protocol, TypeVar

from plinko.engine.drops.threads import thread_count
from plinko.engine.errors import ParameterError

A = TypeVar("A")
R = TypeVar("R")


class Workers(Protocol):
    """Computes calls, this process or a cluster."""

    @property
    def at_once(self) -> int:
        """Number of calls that are computed at the same time."""

    def compute(self, work: Callable[[A, int], R], asked: Iterable[A]) -> Iterator[tuple[A, R]]:
        """Yield each item of `asked` with work(item, threads), in the order of completion.

        threads: how many the call may use. `asked` is read lazily. An exception of `work` is raised
        here. A caller that stops iterating cancels the calls in progress.
        """


@dataclass(frozen=True, slots=True)
class Here:
    """This process, which computes one call after the other on `threads` threads.

    threads: default is one per core.
    """

    threads: int | None = None

    @property
    def at_once(self) -> int:
        return 1

    def compute(self, work: Callable[[A, int], R], asked: Iterable[A]) -> Iterator[tuple[A, R]]:
        threads = thread_count(self.threads)
        for each in asked:
            yield each, work(each, threads)


def workers_at(cluster: str | None, threads: int | None = None) -> AbstractContextManager[Workers]:
    """Return the workers of a cluster, or for None this process with `threads` threads.

    cluster: `local:N` starts N processes on this machine, `local` one per core;
    `tcp://host:8786` is the address of a Dask scheduler.

    Raises ParameterError for any other address, and ClusterError if the scheduler does not answer,
    has no workers, or has workers with other physics or kernels.
    """
    if cluster is None:
        return nullcontext(Here(threads))
    if threads is not None:
        raise ParameterError(
            f"threads is {threads}, which has no effect on a cluster: use local:{threads} instead",
            field="threads",
        )
    # Dask is imported only when it is used, because that takes a second and it may be missing.
    opened: Any = import_module("plinko.engine.batches.cluster").opened
    workers: AbstractContextManager[Workers] = opened(cluster)
    return workers
