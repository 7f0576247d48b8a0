"""A server process to measure: started on a free port, observed from outside, stopped."""

import contextlib
import os
import select
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from benchmarks.harness.effort import MissingError

OPTIONS = (
    *("--drop-rate", "1000000", "--max-clients", "5000"),
    *("--trusted-proxies", "127.0.0.1"),
)
"""Options for servers under load from one address, as from a proxy that serves many clients."""

READY = 120.0
"""s; limit for a server's start, during which it may compile the physics."""

_STATUS = Path("/proc/self/status")


@dataclass(frozen=True)
class Served:
    """A running server."""

    process: subprocess.Popen[str]
    address: str

    @property
    def cpu(self) -> float:
        """User and system time until now, in s."""
        return processor_time(self.process.pid)

    @property
    def resident(self) -> float:
        """Resident memory in bytes."""
        for line in Path(f"/proc/{self.process.pid}/status").read_text().splitlines():
            if line.startswith("VmRSS:"):
                return float(line.split()[1]) * 1024.0
        raise MissingError("this system does not report the resident memory of a process")

    def metrics(self) -> dict[str, float]:
        """The samples of /metrics, by name with labels."""
        with urllib.request.urlopen(f"{self.address}/metrics", timeout=10.0) as answer:
            lines = answer.read().decode().splitlines()
        pairs = (line.rpartition(" ") for line in lines if not line.startswith("#"))
        return {name: float(value) for name, _, value in pairs}


def processor_time(pid: int) -> float:
    """User and system time of a process until now, in s."""
    with contextlib.suppress(OSError, AttributeError):
        # The id of another process's clock, as clock_getcpuclockid(3) computes it on Linux.
        return time.clock_gettime((~pid << 3) | 2)
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory(pid: int) -> float:
    """Bytes of a process and its descendants; shared memory counts once."""
    found = 0.0
    for each in _family(pid):
        with contextlib.suppress(OSError):
            for line in Path(f"/proc/{each}/smaps_rollup").read_text().splitlines():
                if line.startswith("Pss:"):
                    found += 1024.0 * float(line.split()[1])
    return found


def worked(pid: int) -> float:
    """User and system time of a process and its descendants, also ended ones, until now, in s."""
    ticks = 0
    for each in _family(pid):
        with contextlib.suppress(OSError):
            fields = Path(f"/proc/{each}/stat").read_text().rpartition(")")[2].split()
            ticks += sum(map(int, fields[11:15]))
    return ticks / os.sysconf("SC_CLK_TCK")


def _family(pid: int) -> list[int]:
    found = [pid]
    with contextlib.suppress(OSError):
        for task in Path(f"/proc/{pid}/task").iterdir():
            for child in (task / "children").read_text().split():
                found += _family(int(child))
    return found


def can_watch() -> bool:
    """Whether /proc exists, from which this module reads time and memory of processes."""
    return _STATUS.exists()


def core_for_server() -> int | None:
    """The core that is reserved for the server; None if there is only one core."""
    cores = sorted(os.sched_getaffinity(0))
    return cores[-1] if len(cores) > 1 else None


@contextlib.contextmanager
def serving(arguments: Sequence[str] = (), log: IO[str] | None = None) -> Iterator[Served]:
    """Run `plinko serve` with these arguments until the block ends; its log goes to `log`."""
    with tempfile.TemporaryDirectory() as directory:
        given = ["serve", "--port", "0", "--data", directory, *arguments]
        with started(given, "/readyz", log) as found:
            yield found


@contextlib.contextmanager
def started(arguments: Sequence[str], answers: str, log: IO[str] | None = None) -> Iterator[Served]:
    """Run a serving command of `plinko`; the block begins when the path `answers` responds."""
    process = subprocess.Popen(
        [sys.executable, "-m", "plinko", *arguments],
        cwd=Path(__file__).parents[2],
        stdout=subprocess.PIPE,
        stderr=log or subprocess.DEVNULL,
        text=True,
    )
    try:
        yield Served(process, _address(process, answers))
    finally:
        stop(process)


def pinned(process: subprocess.Popen[str], core: int | None) -> None:
    """Pin every thread of a process to one core; do nothing if `core` is None."""
    if core is None:
        return
    for thread in Path(f"/proc/{process.pid}/task").iterdir():
        os.sched_setaffinity(int(thread.name), {core})


def stop(process: subprocess.Popen[str]) -> None:
    """Stop a process by SIGINT, and kill it if that takes too long."""
    process.send_signal(signal.SIGINT)
    try:
        process.wait(15)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    if process.stdout is not None:
        process.stdout.close()


def _address(process: subprocess.Popen[str], answers: str) -> str:
    """Read the address that a server prints, and wait until the path `answers` responds."""
    assert process.stdout is not None
    if not select.select([process.stdout], [], [], READY)[0]:
        raise MissingError(f"the server printed no address within {READY:.0f} s")
    line = process.stdout.readline()
    if not line:
        raise MissingError(f"the server ended with exit code {process.wait(READY)}")
    address = line.split()[-1].rstrip("/")
    end = time.monotonic() + READY
    while time.monotonic() < end:
        try:
            with urllib.request.urlopen(f"{address}{answers}", timeout=2.0):
                return address
        except OSError:  # not ready yet
            time.sleep(0.1)
    raise MissingError(f"the server was not ready within {READY:.0f} s")
