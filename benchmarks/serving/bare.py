"""The lower bound of the cost of sending: python -m benchmarks.serving.bare CLIENTS.

Accepts CLIENTS connections on a free port, which it prints. Then, for each line `BYTES HZ SECONDS`
on its standard input, it sends BYTES bytes to every client HZ times a second for SECONDS and prints
how many sends succeeded. The benchmark measures the processor time of this process. numba compiles
the loop, which calls send(2) of the C library: no interpreter, no event loop, no bookkeeping.
"""

import ctypes
import socket
import sys
import time

import numpy as np
import numpy.typing as npt
from numba import njit

_FLAGS = socket.MSG_DONTWAIT | socket.MSG_NOSIGNAL

_send = ctypes.CDLL(None).send
_send.argtypes = [ctypes.c_int, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int]
_send.restype = ctypes.c_ssize_t


@njit(cache=False)
def broadcast(descriptors: npt.NDArray[np.int32], address: int, size: int) -> int:
    """Send `size` bytes at `address` to each socket; returns how many sockets took all of them."""
    whole = 0
    for descriptor in descriptors:
        whole += _send(descriptor, address, size, _FLAGS) == size
    return whole


def main(clients: int) -> None:
    """Serve until standard input ends."""
    with socket.create_server(("127.0.0.1", 0), backlog=4096) as listener:
        broadcast(np.zeros(0, np.int32), 0, 0)
        print(f"bare sender at 127.0.0.1:{listener.getsockname()[1]}", flush=True)
        connections = [listener.accept()[0] for _ in range(clients)]
    for connection in connections:
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    descriptors = np.array([connection.fileno() for connection in connections], np.int32)
    for line in sys.stdin:
        size, rate, seconds = line.split()
        print(_run(descriptors, int(size), float(rate), float(seconds)), flush=True)


def _run(descriptors: npt.NDArray[np.int32], size: int, rate: float, seconds: float) -> int:
    buffer = np.zeros(size, np.uint8)
    sent = 0
    begin = time.monotonic()
    for tick in range(int(rate * seconds)):
        time.sleep(max(0.0, begin + (tick + 1) / rate - time.monotonic()))
        sent += broadcast(descriptors, buffer.ctypes.data, size)
    return sent


if __name__ == "__main__":
    main(int(sys.argv[1]))
