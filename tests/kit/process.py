"""Programs that tests start, wait for, stop, kill and restart."""

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Final, Self

from tests.kit.address import Address
from tests.kit.port import free_port
from tests.kit.waiting import LIMIT, first_line, until

SERVE: Final = ("serve", "--drop-rate", "1000")
OPERATOR: Final = "an operator's token for the tests"
_FILES: Final = tempfile.TemporaryDirectory(prefix="plinko-")


@dataclass(kw_only=True)
class Program:
    """A program, which ends at the end of a `with` block at the latest.

    answers: whether it is ready; options: of Popen; data: a server's data directory, if it is
    not among the flags. By default that would belong to the port, which another run of the tests
    may have used with another ledger.
    """

    LAST: ClassVar = signal.SIGTERM
    """The signal that ends it at the end of a `with` block."""

    command: Sequence[str | Path] = ()
    environment: dict[str, str] = field(default_factory=dict)
    answers: Callable[[], bool] = lambda: True
    options: Mapping[str, Any] = field(
        default_factory=lambda: {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    )
    data: str = field(default_factory=lambda: tempfile.mkdtemp(dir=_FILES.name))
    process: "subprocess.Popen[str] | None" = None
    said: tuple[str, str] = ("", "")
    """What the last process had written to its pipes and no test had read: output, errors."""

    @property
    def running(self) -> "subprocess.Popen[str]":
        """Its process; fails if it does not run."""
        assert self.process is not None
        return self.process

    def begin(self) -> None:
        """Start it without waiting until it is ready."""
        environment = os.environ | {"PLINKO_DATA": self.data} | self.environment
        self.process = subprocess.Popen(self.command, env=environment, text=True, **self.options)

    def wait(self) -> None:
        """Return when it is ready."""

        def answers() -> bool:
            assert self.running.poll() is None, f"{self.command[0]} ended while it was to start"
            return self.answers()

        until(answers)

    def start(self) -> None:
        self.begin()
        self.wait()

    def send(self, number: signal.Signals) -> None:
        self.running.send_signal(number)

    def end(self, how: signal.Signals = signal.SIGTERM) -> int:
        """Send a signal and wait; returns the exit code."""
        self.send(how)
        return self.ended()

    def ended(self) -> int:
        """Wait until it has ended; returns the exit code."""
        ended, self.process = self.running, None
        self.said = ended.communicate(timeout=LIMIT)
        return ended.returncode

    def __enter__(self) -> Self:
        try:
            self.start()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        if self.process is not None:
            self.end(self.LAST)


@dataclass
class ServerProcess(Program, Address):
    """`plinko serve`, which restarts at the same port with the same ledger.

    ledger: its address; flags: of the command; program: Python's arguments before these flags;
    name: the server's name if several share the ledger.
    """

    LAST: ClassVar = signal.SIGKILL

    ledger: str = ""
    flags: tuple[str, ...] = ()
    program: tuple[str, ...] = ("-m", "plinko", *SERVE)
    name: str = ""
    port: int = field(default_factory=free_port)
    options: Mapping[str, Any] = field(
        default_factory=lambda: {"stdout": subprocess.PIPE}, kw_only=True
    )
    starts: list[float] = field(default_factory=list)  # seconds that each start took

    def __post_init__(self) -> None:
        self.url = f"http://127.0.0.1:{self.port}"

    def begin(self) -> None:
        flags = ("--name", self.name, *self.flags) if self.name else self.flags
        self.command = [sys.executable, *self.program, "--port", str(self.port), *flags]
        self.environment = {"PLINKO_OPERATOR_TOKEN": OPERATOR, **self.environment}
        if self.ledger:
            self.environment["PLINKO_DATABASE_URL"] = self.ledger
        super().begin()

    def wait(self) -> None:
        line = first_line(self.running)
        if line != f"Plinko is at {self.url}/\n":
            self.running.kill()
            raise AssertionError(f"the server said {line!r}", self.running.communicate())

    def start(self) -> None:
        began = time.monotonic()
        super().start()
        self.starts.append(time.monotonic() - began)
