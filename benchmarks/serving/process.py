"""A server to measure: started on a free port of this machine, watched from outside, stopped."""

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
"""For servers that are to be loaded from one address, as by a proxy that speaks for many."""

READY = 120.0
"""s that a server may take to start, which may compile the physics."""

_STATUS = Path("/proc/self/status")


@dataclass(frozen=True)
class Served:
    """A running server: its process and its address."""

    process: subprocess.Popen[str]
    address: str

    @property
    def cpu(self) -> float:
        """User and system time so far, in s."""
        return processor_time(self.process.pid)

    @property
    def resident(self) -> float:
        """Resident memory in bytes."""
        for line in Path(f"/proc/{self.process.pid}/status").read_text().splitlines():
            if line.startswith("VmRSS:"):
                return float(line.split()[1]) * 1024.0
        raise MissingError("the system does not tell the resident memory of a process")

    def metrics(self) -> dict[str, float]:
        """Every sample of /metrics by its name with labels."""
        with urllib.request.urlopen(f"{self.address}/metrics", timeout=10.0) as answer:
            lines = answer.read().decode().splitlines()
        pairs = (line.rpartition(" ") for line in lines if not line.startswith("#"))
        return {name: float(value) for name, _, value in pairs}


def processor_time(pid: int) -> float:
    """User and system time of a process so far, in s."""
    with contextlib.suppress(OSError, AttributeError):
        # The clock of another process, as clock_getcpuclockid(3) names it on Linux.
        return time.clock_gettime((~pid << 3) | 2)
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory(pid: int) -> float:
    """Bytes of a process and of all that it started, what they share counted once."""
    found = 0.0
    for each in _family(pid):
        with contextlib.suppress(OSError):
            for line in Path(f"/proc/{each}/smaps_rollup").read_text().splitlines():
                if line.startswith("Pss:"):
                    found += 1024.0 * float(line.split()[1])
    return found


def worked(pid: int) -> float:
    """User and system time so far of a process and of all that it started, ended ones too; in s."""
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
    """Whether this system tells of a process what is asked here."""
    return _STATUS.exists()


def core_for_server() -> int | None:
    """The core that the server gets for itself, where there are two."""
    cores = sorted(os.sched_getaffinity(0))
    return cores[-1] if len(cores) > 1 else None


@contextlib.contextmanager
def serving(arguments: Sequence[str] = (), log: IO[str] | None = None) -> Iterator[Served]:
    """Run `plinko serve` with these arguments until the block ends; `log` gets what it logs."""
    with tempfile.TemporaryDirectory() as directory:
        given = ["serve", "--port", "0", "--data", directory, *arguments]
        with started(given, "/readyz", log) as found:
            yield found


@contextlib.contextmanager
def started(arguments: Sequence[str], answers: str, log: IO[str] | None = None) -> Iterator[Served]:
    """Run a command of `plinko` that serves, from when this path answers until the block ends."""
    process = subprocess.Popen(
        [sys.executable, "-m", "app.cli", *arguments],
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
    """Keep every thread of a process on one core."""
    if core is None:
        return
    for thread in Path(f"/proc/{process.pid}/task").iterdir():
        os.sched_setaffinity(int(thread.name), {core})


def stop(process: subprocess.Popen[str]) -> None:
    """End a process that was started here."""
    process.send_signal(signal.SIGINT)
    try:
        process.wait(15)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    if process.stdout is not None:
        process.stdout.close()


def _address(process: subprocess.Popen[str], answers: str) -> str:
    """The address that a server prints once it can be used."""
    assert process.stdout is not None
    if not select.select([process.stdout], [], [], READY)[0]:
        raise MissingError(f"the server said nothing within {READY:.0f} s")
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
