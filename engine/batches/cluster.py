"""Computes on the workers of a Dask cluster; only this module imports Dask.

The cluster is given only a few calls per thread in advance, so that the scheduler and this process
need little memory. If a worker is lost, others repeat its calls.
"""

import logging
import pickle
import re
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import lru_cache
from importlib.util import find_spec
from itertools import chain, islice
from typing import TYPE_CHECKING, Any, Final, TypeVar

from plinko.engine.drops.threads import thread_count
from plinko.engine.errors import ClusterError, ParameterError
from plinko.engine.jit import source_hash

if TYPE_CHECKING:
    from distributed import Client, Future

A = TypeVar("A")
R = TypeVar("R")

AHEAD: Final = 3
"""Calls submitted per thread of the workers: one is being computed, the others wait there."""

THREADS_A_CALL: Final = 40
"""A call gets one more item for each 40 threads of the cluster. A scheduler manages a few hundred
calls a second, and a thousand workers can compute thousands of blocks in that time."""

LOST: Final = 5
"""Times that a call is submitted again after Dask has lost workers with it three times. After that
the call itself probably ends the workers."""

CONNECTING: Final = "10s"
"""Time-out for a scheduler's first answer."""

_REMEMBERED: Final = 8  # kinds of work that a worker caches, each with its prepared board


def local_workers(address: str) -> int | None:
    """The number of workers for an address `local[:N]`; None for a scheduler's address.

    Raises ParameterError for any other address.
    """
    found = re.fullmatch(r"local(?::([1-9]\d{0,3}))?", address)
    if found is not None:
        return int(found[1]) if found[1] else thread_count(None)
    if re.fullmatch(r"(tcp|tls)://[^\s/:]+:\d{1,5}|(tcp|tls)://\[[0-9a-fA-F:]+\]:\d{1,5}", address):
        return None
    raise ParameterError(
        f"cluster {address!r} is not valid: use local, local:4 or an address such as "
        "tcp://scheduler:8786",
        field="cluster",
    )


@contextmanager
def opened(address: str) -> Iterator["Cluster"]:
    """The cluster at an address, after checking that its workers compute the same as this process.

    Raises ParameterError for a malformed address, ClusterError if the cluster cannot be used.
    """
    count = local_workers(address)
    if find_spec("distributed") is None:
        raise ClusterError(
            "a cluster needs Dask, which is not installed: pip install 'plinko-sim[batches]'",
            field="cluster",
        )
    from distributed.utils import silence_logging_cmgr  # noqa: PLC0415

    with ExitStack() as stack:
        # Dask would log a lost scheduler as several tracebacks; `compute` raises one error.
        for name in ("distributed", "distributed.client"):
            stack.enter_context(silence_logging_cmgr(logging.CRITICAL, name))
        client = stack.enter_context(_local(stack, count) if count else _remote(address))
        check(address, client.run(who, on_error="return"))
        yield Cluster(client)


def _local(stack: ExitStack, count: int) -> "Client":
    """A client of `count` new processes with one thread each, which end with the client."""
    from distributed import Client, LocalCluster  # noqa: PLC0415

    cluster = stack.enter_context(
        LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            dashboard_address=None,
            # The scheduler opens an HTTP port even without a dashboard. With port 0 the system
            # chooses a free one; the default may be in use.
            scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},
            worker_dashboard_address=None,
            preload=__name__,
            silence_logs=logging.CRITICAL,
        )
    )
    return Client(cluster)


def dask_setup(_worker: Any) -> None:
    """Have a local worker ignore Ctrl-C, which then reaches only the client, which ends it.

    Dask calls the function of this name in a preloaded module.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _remote(address: str) -> "Client":
    from distributed import Client  # noqa: PLC0415

    try:
        return Client(address, timeout=CONNECTING)
    except (OSError, ValueError) as error:  # TimeoutError is an OSError
        raise ClusterError(f"no scheduler answers at {address}: {error}", field="cluster") from None


def who() -> dict[str, Any]:
    """What a worker must share with this process: the physics version and the kernels' sources."""
    return source_hash.current()


def check(address: str, answers: dict[str, Any]) -> None:
    """Raise ClusterError unless there are workers and the answers of all match `who()`."""
    if not answers:
        raise ClusterError(
            f"the scheduler at {address} has no workers: start some with `dask worker {address}`",
            field="cluster",
        )
    for worker, theirs in answers.items():
        if not isinstance(theirs, dict):
            raise ClusterError(
                f"the worker {worker} cannot compute drops: {theirs!r}; install the same release "
                "of plinko-sim there",
                field="cluster",
            )
        _compare(worker, theirs)


def _compare(worker: str, theirs: dict[str, Any], ours: dict[str, Any] | None = None) -> None:
    ours = who() if ours is None else ours
    names = {"physics_version": "PHYSICS_VERSION", "sources": "kernels with the digest"}
    for key, name in names.items():
        if theirs.get(key) != ours[key]:
            raise ClusterError(
                f"the worker {worker} has {name} {theirs.get(key)}, but this process has "
                f"{ours[key]}: install the same release of plinko-sim there",
                field="cluster",
            )


def together(threads: int) -> int:
    """Items in a call, if there are enough items for all threads."""
    return 1 + threads // THREADS_A_CALL


@lru_cache(maxsize=_REMEMBERED)
def _unpacked(work: bytes) -> Callable[[Any, int], Any]:
    """Unpickle work; cached, so that a worker prepares its board only once."""
    found: Callable[[Any, int], Any] = pickle.loads(work)
    return found


def call(ours: dict[str, Any], work: bytes, asked: Sequence[Any]) -> list[Any]:
    """On a worker, apply `work` to each item of `asked`.

    Raises ClusterError if this worker differs from the client: it may have joined the cluster after
    the client checked the others.
    """
    _compare("that took this work", who(), ours)
    compute = _unpacked(work)
    return [compute(each, 1) for each in asked]


class Cluster:
    """The workers of a Dask client; each thread computes one call at a time."""

    def __init__(self, client: "Client") -> None:
        self._client = client
        self.at_once = max(sum(client.nthreads().values()), 1)

    def compute(self, work: Callable[[A, int], R], asked: Iterable[A]) -> Iterator[tuple[A, R]]:
        """Yield each item of `asked` with its result, in the order in which results arrive."""
        from distributed import as_completed  # noqa: PLC0415

        packed, calls = pickle.dumps(work), self._calls(asked)
        waiting: dict[Future[Any], tuple[Sequence[A], int]] = {}
        ready = as_completed(with_results=True, raise_errors=False, loop=self._client.loop)

        def submit(some: Sequence[A], lost: int = 0) -> None:
            try:
                future = self._client.submit(call, who(), packed, some, pure=False)
            except OSError:  # such as CommClosedError: the connection was lost a moment ago
                raise _gone() from None
            waiting[future] = some, lost
            ready.add(future)

        try:
            for some in islice(calls, AHEAD * self.at_once):
                submit(some)
            for future, results in ready:
                some, lost = waiting.pop(future)
                if future.status == "finished":
                    for following in islice(calls, 1):
                        submit(following)
                    yield from zip(some, results, strict=True)
                else:
                    submit(some, _lost_again(future, lost))
        finally:
            self._client.cancel(list(waiting))

    def _calls(self, asked: Iterable[A]) -> Iterator[Sequence[A]]:
        """Divide `asked` into calls of `together` items, or fewer if threads would get none."""
        handed_out = AHEAD * self.at_once
        todo = iter(asked)
        first = list(islice(todo, handed_out * together(self.at_once)))
        size = max(len(first) // handed_out, 1)
        everything = chain(first, todo)
        while some := tuple(islice(everything, size)):
            yield some


def _gone() -> ClusterError:
    return ClusterError(
        "the scheduler is gone, and the unfinished calls are lost: start another and run again; a "
        "batch with --resume keeps its finished blocks"
    )


def _lost_again(future: "Future[Any]", lost: int) -> int:
    """Return how often a call's workers were lost; raise any other failure of the call."""
    from distributed import KilledWorker  # noqa: PLC0415

    if future.status != "error":
        raise _gone()
    error = future.exception()
    assert error is not None
    if not isinstance(error, KilledWorker) or lost >= LOST:
        raise error
    return lost + 1
