"""A port that a test reserved stays reserved."""

import random
import socket
from pathlib import Path

import pytest

from tests.kit.port import PORTS, free_port

RANGE = Path("/proc/sys/net/ipv4/ip_local_port_range")


@pytest.mark.skipif(not RANGE.exists(), reason="the system does not say which it gives away")
def test_no_outgoing_connection_gets_a_port_given_to_a_test() -> None:
    first, _ = map(int, RANGE.read_text().split())
    assert free_port() < first


def test_no_two_tests_get_the_same_port(monkeypatch: pytest.MonkeyPatch) -> None:
    taken = free_port()
    with socket.create_server(("127.0.0.1", free_port())) as server:
        listening = server.getsockname()[1]
        free = free_port()
        order = [taken, listening, free - 1, *PORTS]
        monkeypatch.setattr(random, "sample", lambda *_: order)
        assert free_port() not in (taken, listening, free)
