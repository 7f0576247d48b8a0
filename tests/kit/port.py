"""Ports for servers that tests start, also a second time: nobody else gets them in between."""

import random
import socket
from typing import Final

PORTS: Final = range(20_000, 32_768)
"""Below those that a system gives to outgoing connections, on Linux from 32768 on. One of these may
be taken before a server starts at it, or connect to itself while a test waits for that server."""


def free_port() -> int:
    """A TCP port of the loopback for this process, for as long as it lives.

    It keeps the UDP port of the same number, which says so to other processes that ask here.
    """
    for port in random.sample(PORTS, len(PORTS)):
        mark = socket.socket(type=socket.SOCK_DGRAM)
        try:
            mark.bind(("127.0.0.1", port))
            socket.create_server(("127.0.0.1", port)).close()
        except OSError:
            mark.close()
        else:
            mark.detach()  # it stays bound until this process ends
            return port
    raise OSError(f"no port of {PORTS} is free")
