"""A TCP forwarder that a test can cut, like a network that drops packets."""

import contextlib
import socket
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from tests.kit.waiting import until

Dial = Callable[[], socket.socket]
"""Opens a connection to the program behind the forwarder."""

_PIECE = 1 << 16  # bytes


@dataclass
class Forwarder:
    """Forwards TCP both ways. While it is cut it keeps all bytes back and closes no connection.

    After `heal` the bytes arrive, like retransmitted packets, unless their sender has given up.
    """

    dial: Dial
    listener: socket.socket
    whole: threading.Event = field(default_factory=threading.Event)
    held: int = 0  # pieces received while it was cut
    _sockets: list[socket.socket] = field(default_factory=list)
    _threads: list[threading.Thread] = field(default_factory=list)
    _closing: bool = False

    @property
    def port(self) -> int:
        port: int = self.listener.getsockname()[1]
        return port

    def cut(self) -> None:
        """Keep everything back from now on; neither side notices a closed connection."""
        self.whole.clear()

    def heal(self) -> None:
        self.whole.set()

    def run(self) -> None:
        """Accept connections until `close`."""
        with contextlib.suppress(OSError):
            while True:
                near, _ = self.listener.accept()
                self._begin(self._take, near)

    def _begin(self, work: Callable[..., None], *values: socket.socket) -> None:
        self._sockets += values
        if self._closing:
            self._end_all()  # also the sockets that `close` did not know yet
        thread = threading.Thread(target=work, args=values, daemon=True)
        self._threads.append(thread)
        thread.start()

    def _take(self, near: socket.socket) -> None:
        self.whole.wait()
        with contextlib.suppress(OSError):
            far = self.dial()
            self._begin(self._pump, near, far)
            self._pump(far, near)

    def _pump(self, source: socket.socket, target: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while piece := source.recv(_PIECE):
                self.held += not self.whole.is_set()
                self.whole.wait()
                target.sendall(piece)
        self.whole.wait()  # a cut also hides that the other side has closed
        with contextlib.suppress(OSError):
            target.shutdown(socket.SHUT_WR)

    def close(self) -> None:
        """Close every connection, and wait for all threads."""
        self._closing = True
        self.heal()
        self._end_all()
        while self._threads:
            self._threads.pop(0).join()
        for each in (self.listener, *self._sockets):
            each.close()

    def _end_all(self) -> None:
        """Wake the threads that wait in `accept` or `recv`."""
        for each in (self.listener, *self._sockets):
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)


@contextlib.contextmanager
def forwarding(dial: Dial) -> Iterator[Forwarder]:
    """Run a forwarder on a free port; it is not cut at first."""
    forwarder = Forwarder(dial, socket.create_server(("127.0.0.1", 0)))
    forwarder.heal()
    thread = threading.Thread(target=forwarder.run, daemon=True)
    thread.start()
    try:
        yield forwarder
    finally:
        forwarder.close()
        thread.join()


def over_file(path: str) -> Dial:
    """Connect to a Unix socket at this path."""

    def dial() -> socket.socket:
        line = socket.socket(socket.AF_UNIX)
        line.connect(path)
        return line

    return dial


def until_held(forwarder: Forwarder) -> None:
    """Wait until the forwarder has kept something back: the cut has had an effect."""
    until(lambda: forwarder.held)
