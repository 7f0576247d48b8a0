"""Work shared among threads is completed; errors reach the caller, and an interrupt stops it."""

import subprocess
import sys
from threading import Barrier, Event, get_ident

import pytest

from plinko.engine.drops.threads import share
from tests.kit.waiting import LIMIT

INTERRUPTED = """
import signal
from plinko.engine.drops.threads import share

sharing = False

def stop(*_):
    # The system may hand the signal to a worker, which runs late on a busy machine: after `share`.
    if sharing:
        raise KeyboardInterrupt

signal.signal(signal.SIGALRM, stop)
stopped = 0
for k in range(1600):
    try:
        sharing = True
        signal.setitimer(signal.ITIMER_REAL, (k % 400 + 2) * 5e-6)
        share(range(64), lambda part, _: sum(range(200)), 2)
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        sharing = False
    except KeyboardInterrupt:
        sharing = False
        stopped += 1
signal.signal(signal.SIGALRM, signal.SIG_IGN)
print(stopped)
"""


@pytest.mark.parametrize("threads", [1, 2, 3, 100])
def test_every_part_is_done_once_by_one_of_the_workers(threads: int) -> None:
    seen: list[tuple[int, int]] = []

    def work(part: int, worker: int) -> int:
        seen.append((part, worker))
        return 1

    share(range(50), work, threads)
    assert sorted(part for part, _ in seen) == list(range(50))
    assert all(0 <= worker < min(threads, 50) for _, worker in seen)


def test_without_parts_nothing_is_done_or_told() -> None:
    told: list[int] = []
    share([], lambda part, worker: 1 // 0, 2, told.append)
    assert told == []


def test_progress_is_told_on_the_calling_thread_up_to_the_sum() -> None:
    told: list[int] = []
    threads: set[int] = set()

    def tell(done: int) -> None:
        told.append(done)
        threads.add(get_ident())

    share(range(40), lambda part, _: part, 2, tell)
    assert told == sorted(told)
    assert told[-1] == sum(range(40))
    assert threads == {get_ident()}


def test_what_another_thread_does_last_is_told_too() -> None:
    """Worker 1 ends its part after the caller has reported progress for the other part."""
    begun = Barrier(2)
    told: list[int] = []
    heard = Event()

    def work(part: int, worker: int) -> int:
        begun.wait(LIMIT)
        assert worker == 0 or heard.wait(LIMIT)
        return part

    def tell(done: int) -> None:
        told.append(done)
        heard.set()

    share([1, 1], work, 2, tell)
    assert told == [1, 2]


def test_an_error_in_a_thread_reaches_the_caller_and_ends_work() -> None:
    """Worker 0 waits in the first part until worker 1 has failed in the second part."""
    failed = Event()
    begun: list[int] = []

    def work(part: int, worker: int) -> int:
        begun.append(part)
        if worker == 0:
            assert failed.wait(LIMIT)
            return 1
        failed.set()
        raise ZeroDivisionError(part)

    with pytest.raises(ZeroDivisionError):
        share(range(1000), work, 2)
    assert len(begun) < 1000


def test_an_interrupt_at_any_moment_ends_it() -> None:
    """A pool of `concurrent.futures` would hang here: an interrupt leaves its lock taken."""
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED], capture_output=True, text=True, check=False,
        timeout=LIMIT,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    assert int(done.stdout) > 40
