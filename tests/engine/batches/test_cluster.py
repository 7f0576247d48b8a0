"""Blocks on a real Dask cluster of local processes, and the errors that come before any work."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path
from typing import Any

import pytest

from plinko.app.batches.saved import load
from plinko.app.cli import main
from plinko.engine import ParameterError, drop_many
from plinko.engine.batches import cluster
from plinko.engine.batches.block import block_of
from plinko.engine.batches.job import Job
from plinko.engine.batches.tally import Tally
from plinko.engine.batches.workers import Workers, workers_at
from plinko.engine.drops.digest import BLOCK
from plinko.engine.errors import ClusterError
from plinko.engine.parameters import Exact
from tests.engine.batches.open_board import DROPS, OPEN


@pytest.fixture(scope="module")
def workers() -> Iterator[Workers]:
    with workers_at("local:1") as found:
        yield found


def digest_on(workers: Workers, job: Job) -> str | None:
    tally = Tally(job)
    for _, block in workers.compute(partial(block_of, job), tally.missing()):
        tally.add(block)
    return tally.digest


def test_a_cluster_computes_the_same_batch_and_raises_its_errors(
    workers: Workers,
) -> None:
    assert digest_on(workers, Job(OPEN, Exact(), 0, DROPS)) == drop_many(OPEN, range(DROPS)).digest
    with pytest.raises(ParameterError, match="'nobody'"):
        list(workers.compute(_refuse, ["nobody"]))
    asked = iter(range(10**9))
    found = workers.compute(max, asked)
    assert next(found) in {(0, 1), (1, 1), (2, 2)}
    found.close()  # type: ignore[attr-defined]
    assert next(asked) <= 1 + 2 * cluster.AHEAD, "calls are asked for as they are needed"


def test_an_interrupt_is_the_client_s_and_local_workers_go_on(workers: Workers) -> None:
    [(_, worker)] = workers.compute(_interrupted, [0])
    assert worker != os.getpid()
    assert list(workers.compute(_interrupted, [1])) == [(1, worker)]


def test_a_second_cluster_on_this_machine_takes_ports_of_its_own(workers: Workers) -> None:
    """With the same port, Dask would warn, and warnings are errors in tests."""
    with workers_at("local:1") as others:
        assert list(others.compute(max, [1])) == list(workers.compute(max, [1]))


def _interrupted(_number: int, _threads: int) -> int:
    os.kill(os.getpid(), signal.SIGINT)
    return os.getpid()


def _refuse(name: str, _threads: int) -> None:
    raise ParameterError(f"{name!r} is refused", field="name")


OURS = cluster.who()


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ({}, "has no workers: start some with `dask worker tcp://a:1`"),
        ({"tcp://b:2": OURS | {"physics_version": 3}}, "tcp://b:2 has PHYSICS_VERSION 3"),
        (
            {"tcp://b:2": OURS, "tcp://c:3": OURS | {"sources": "f0"}},
            "tcp://c:3 has kernels with the",
        ),
        ({"tcp://b:2": {}}, "PHYSICS_VERSION None"),
        (
            {"tcp://b:2": ModuleNotFoundError("No module named 'engine'")},
            "No module named 'engine'",
        ),
    ],
)
def test_workers_that_would_compute_something_else_are_refused(
    told: dict[str, Any], said: str
) -> None:
    with pytest.raises(ClusterError, match=said):
        cluster.check("tcp://a:1", told)
    cluster.check("tcp://a:1", {"tcp://b:2": OURS})


def test_a_later_worker_refuses_work_of_another_release() -> None:
    with pytest.raises(ClusterError, match="PHYSICS_VERSION"):
        cluster.call(OURS | {"physics_version": 99}, b"", [1])


@pytest.mark.parametrize(
    "bad", ["", "locale", "local:", "local:0", "local:-1", "tcp://", "tcp://host", "host:8786"]
)
def test_a_bad_address_is_named(bad: str) -> None:
    with pytest.raises(
        ParameterError, match="is not valid: use local, local:4 or an address"
    ) as caught:
        cluster.local_workers(bad)
    assert repr(bad) in str(caught.value)


def test_addresses_say_how_many_workers_are_started() -> None:
    assert cluster.local_workers("local:7") == 7
    assert cluster.local_workers("local") == len(os.sched_getaffinity(0))
    for address in ("tcp://127.0.0.1:8786", "tls://scheduler:1", "tcp://[::1]:8786"):
        assert cluster.local_workers(address) is None


class _Threads:
    """A stand-in for a Dask client, which only knows its number of threads."""

    def __init__(self, threads: int) -> None:
        self._threads = threads

    def nthreads(self) -> dict[str, int]:
        return {"tcp://a:1": self._threads - 1, "tcp://b:2": 1}


@pytest.mark.parametrize(
    ("threads", "asked", "size"),
    [(2, 10**4, 1), (400, 10**5, 11), (400, 1200, 1), (400, 2400, 2), (400, 5, 1), (400, 0, 0)],
)
def test_a_call_takes_more_with_many_threads_and_much_work(
    threads: int, asked: int, size: int
) -> None:
    calls = list(cluster.Cluster(_Threads(threads))._calls(range(asked)))  # type: ignore[arg-type]
    assert [each for some in calls for each in some] == list(range(asked))
    assert max(map(len, calls), default=0) == size


def test_threads_are_not_a_cluster_s() -> None:
    with pytest.raises(ParameterError, match="local:3"):
        workers_at("local:2", threads=3)


kills = pytest.mark.long("scheduler, workers and client are killed")


class Machines:
    """A scheduler and its workers, each in a separate process."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._started: list[subprocess.Popen[bytes]] = []
        file = folder / "scheduler.json"
        self.scheduler = self._start(
            "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
            "--scheduler-file", str(file),
        )  # fmt: skip
        line = b""
        assert self.scheduler.stderr is not None
        while b"Scheduler at:" not in line:
            line = self.scheduler.stderr.readline()
        self.address = line.split()[-1].decode()

    def _start(self, what: str, *arguments: str) -> "subprocess.Popen[bytes]":
        process = subprocess.Popen(
            [sys.executable, "-m", "dask", what, *arguments],
            stderr=subprocess.PIPE, cwd=self._folder,
        )  # fmt: skip
        self._started.append(process)
        return process

    def worker(self) -> "subprocess.Popen[bytes]":
        process = self._start(
            "worker", self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard",
            "--host", "127.0.0.1",
        )  # fmt: skip
        assert process.stderr is not None
        while b"Registered to:" not in (line := process.stderr.readline()):
            assert line, "the worker ended"
        return process

    def end(self) -> None:
        for process in reversed(self._started):
            process.kill()
            process.communicate()


@pytest.fixture
def machines(tmp_path: Path) -> Iterator[Machines]:
    started = Machines(tmp_path)
    yield started
    started.end()


MANY = Job(OPEN, Exact(), 0, 40 * BLOCK)


@cache
def many_digest() -> str:
    return drop_many(OPEN, range(MANY.drops)).digest


@kills
def test_killed_workers_cost_time_and_no_block(machines: Machines) -> None:
    running = [machines.worker(), machines.worker()]
    tally = Tally(MANY)
    with workers_at(machines.address) as found:
        for k, (_, block) in enumerate(found.compute(partial(block_of, MANY), tally.missing())):
            tally.add(block)
            if k % 4 == 3 and k < 32:
                running.append(machines.worker())
                running.pop(0).kill()
    assert tally.digest == many_digest()


@kills
def test_a_killed_client_goes_on_where_it_was(machines: Machines, tmp_path: Path) -> None:
    machines.worker()
    process, kept = client(machines, tmp_path)
    while not kept.exists():
        assert process.poll() is None
    process.kill()
    process.communicate()
    before = load(kept)[0].drops
    assert before > 0
    again, _ = client(machines, tmp_path)
    assert again.wait() == 0
    again.communicate()
    assert load(kept)[0].digest == many_digest()


@kills
def test_a_killed_scheduler_leaves_what_was_done(machines: Machines, tmp_path: Path) -> None:
    machines.worker()
    process, kept = client(machines, tmp_path)
    while not kept.exists():
        assert process.poll() is None
    machines.scheduler.kill()
    _, said = process.communicate()
    assert (process.returncode, said.count(b"\n")) == (2, 1)
    assert said.startswith(b"plinko: the scheduler is gone")
    assert load(kept)[0].drops > 0
    board = str(tmp_path / "open.json")
    assert main(["simulate", board, "--drops", str(MANY.drops), "--resume", str(kept)]) == 0
    assert load(kept)[0].digest == many_digest()


@kills
def test_an_interrupted_client_says_what_it_has(machines: Machines, tmp_path: Path) -> None:
    machines.worker()
    process, kept = client(machines, tmp_path)
    while not kept.exists():
        assert process.poll() is None
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate()
    assert process.returncode == 130
    assert f"{load(kept)[0].drops:,} of {MANY.drops:,} drops".encode() in out


@kills
def test_a_scheduler_without_workers_or_none_at_all_is_one_line(
    machines: Machines, tmp_path: Path
) -> None:
    process, _ = client(machines, tmp_path)
    _, said = process.communicate()
    assert (process.returncode, said.count(b"\n")) == (2, 1)
    assert b"has no workers" in said
    machines.scheduler.kill()
    machines.scheduler.wait()
    process, _ = client(machines, tmp_path)
    _, said = process.communicate()
    assert (process.returncode, said.count(b"\n")) == (2, 1)
    assert b"no scheduler answers at " + machines.address.encode() in said


def client(machines: Machines, folder: Path) -> "tuple[subprocess.Popen[bytes], Path]":
    board, kept = folder / "open.json", folder / "kept.json"
    board.write_text(OPEN.to_json())
    process = subprocess.Popen(
        [
            sys.executable, "-m", "plinko", "simulate", str(board), "--drops", str(MANY.drops),
            "--cluster", machines.address, "--resume", str(kept),
        ],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    return process, kept
