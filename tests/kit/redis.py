"""A private Redis for the tests, on a free port of the loopback; it can be restarted."""

import contextlib
import shutil
import signal
import socket

from tests.kit.port import free_port
from tests.kit.process import Program

PROGRAM = shutil.which("redis-server")
MISSING = "no Redis: apt-get install redis-server"


class Redis(Program):
    """A Redis server that keeps nothing on disk."""

    LAST = signal.SIGKILL

    def __init__(self) -> None:
        assert PROGRAM is not None
        self.port = free_port()
        self.url = f"redis://127.0.0.1:{self.port}"
        options = ["--port", str(self.port), "--bind", "127.0.0.1", "--save", "", "--dir", "/tmp"]
        super().__init__(command=[PROGRAM, *options], answers=self._answers)

    def _answers(self) -> bool:
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", self.port), 1.0):
            return True
        return False
