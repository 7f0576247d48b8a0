"""Ports for servers that tests start and restart: each port stays reserved in between."""

import random
import socket
from typing import Final

PORTS: Final = range(20_000, 32_768)
"""Below the ephemeral ports, which Linux gives to outgoing connections from 32768 on. An ephemeral
port may be taken before the server starts, and a client that polls it may connect to itself."""


def free_port() -> int:
    """Reserve a TCP port of the loopback until this process ends.

    This process binds the UDP port of the same number, so that no other test process picks it.
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
