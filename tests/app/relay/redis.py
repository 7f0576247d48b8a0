"""A Redis of the tests' own, on a free port of the loopback; it can end and be started again."""

import contextlib
import shutil
import socket
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass, field

from tests.ports import free_port
from tests.waiting import until

PROGRAM = shutil.which("redis-server")
MISSING = "no Redis: apt-get install redis-server"


@dataclass
class Redis:
    """Keeps nothing on disk."""

    port: int
    process: "subprocess.Popen[bytes] | None" = field(default=None)

    @property
    def url(self) -> str:
        return f"redis://127.0.0.1:{self.port}"

    def start(self) -> None:
        assert PROGRAM is not None
        options = ["--port", str(self.port), "--bind", "127.0.0.1", "--save", "", "--dir", "/tmp"]
        self.process = subprocess.Popen(
            [PROGRAM, *options], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        until(self._answers)

    def stop(self) -> None:
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            self.process = None

    def _answers(self) -> bool:
        assert self.process is not None
        assert self.process.poll() is None, "Redis ended while it was to start"
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", self.port), 1.0):
            return True
        return False


@contextlib.contextmanager
def running() -> Iterator[Redis]:
    """A new Redis, gone at the end."""
    redis = Redis(free_port())
    redis.start()
    try:
        yield redis
    finally:
        redis.stop()
