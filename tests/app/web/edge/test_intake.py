"""An iteration of the event loop parses little input, and clients take turns."""

import itertools
from collections.abc import Callable
from typing import Any, cast

import pytest

from plinko.app.web.edge.connection import Connection
from plinko.app.web.edge.intake import Intake
from tests.app.web.edge.lines import Line, Server

GIVEN: list[tuple[str, bytes]] = []
"""The client and bytes of each piece that a protocol received."""


class Parser:
    """A protocol that records the pieces it receives."""

    def __init__(self, server: Server, name: str) -> None:
        self.loop = server.loop
        self.name = name
        self.transport: Any = None

    def connection_made(self, transport: Any) -> None:
        self.transport = transport

    def data_received(self, data: bytes) -> None:
        GIVEN.append((self.name, data))

    def connection_lost(self, exc: Exception | None) -> None:
        pass


@pytest.fixture(autouse=True)
def empty_log() -> None:
    GIVEN.clear()


def dial(server: Server, host: str = "192.0.2.1", parser: Parser | None = None) -> Line:
    line = Line(host)
    line.connection = Connection(parser or Parser(server, host), server.edge)
    server.loop.lines.append(line)
    line.connection.connection_made(cast(Any, line))
    return line


def turns(server: Server) -> list[list[tuple[str, bytes]]]:
    """The pieces parsed in each iteration of the loop, until nothing is left."""
    found = [len(GIVEN)]
    while server.loop.turn():
        found.append(len(GIVEN))
    return [GIVEN[start:end] for start, end in itertools.pairwise(found)]


def test_one_client_s_flood_is_parsed_in_pieces_and_not_lost() -> None:
    server = Server()
    line = dial(server)
    sent = bytes(range(256)) * 1000
    line.arriving = sent
    for turn in turns(server):
        assert sum(len(piece) for _, piece in turn) < 2048 + 1024
    assert b"".join(piece for _, piece in GIVEN) == sent


def test_a_flood_over_many_connections_counts_as_one() -> None:
    server = Server(most=1000)
    lines = [dial(server) for _ in range(200)]
    for line in lines:
        line.arriving = b"x" * 5000
    for turn in turns(server):
        assert len(turn) <= 4, "the shortest pieces count for 512 bytes"
        assert sum(len(piece) for _, piece in turn) < 2048 + 1024
    assert sum(len(piece) for _, piece in GIVEN) == 200 * 5000
    # One byte at a time is no more for a turn either.
    GIVEN.clear()
    for _ in range(20):
        for line in lines:
            line.arriving += b"x"
        before = len(GIVEN)
        server.loop.turn()
        assert len(GIVEN) - before <= 4
    turns(server)
    assert sum(len(piece) for _, piece in GIVEN) == 200 * 20


def test_a_small_client_waits_for_one_piece_of_a_flood() -> None:
    server = Server(most=1000)
    for _ in range(100):
        dial(server, "192.0.2.1").arriving = b"x" * 5000
    server.loop.turn()
    dial(server, "192.0.2.2").arriving = b"hello"
    before = len(GIVEN)
    while ("192.0.2.2", b"hello") not in GIVEN:
        server.loop.turn()
    # The rest of the pieces of this iteration, and one more.
    assert GIVEN.index(("192.0.2.2", b"hello")) - before <= 5


def test_a_piece_ends_with_a_head() -> None:
    server = Server()
    line = dial(server)
    line.arriving = b"one\r\n\r\ntwo\r\n\r\nthree"
    turns(server)
    assert [piece for _, piece in GIVEN] == [b"one\r\n\r\n", b"two\r\n\r\n", b"three"]


def test_a_protocol_is_given_no_more_until_it_wants_more() -> None:
    server = Server()
    parser = Parser(server, "")
    line = dial(server, parser=parser)
    line.arriving = b"one\r\n\r\ntwo\r\n\r\n"
    wanting: Callable[..., None] = parser.data_received

    def once(data: bytes) -> None:
        wanting(data)
        parser.transport.pause_reading()

    parser.data_received = once  # type: ignore[method-assign]
    turns(server)
    assert [piece for _, piece in GIVEN] == [b"one\r\n\r\n"]
    assert not line.reading
    parser.transport.resume_reading()
    turns(server)
    assert [piece for _, piece in GIVEN] == [b"one\r\n\r\n", b"two\r\n\r\n"]


def test_a_failing_protocol_ends_only_its_own_connection() -> None:
    server = Server()
    failing = Parser(server, "")

    def fail(data: bytes) -> None:
        raise RuntimeError("here")

    failing.data_received = fail  # type: ignore[method-assign]
    broken, sound = dial(server, parser=failing), dial(server)
    broken.arriving = sound.arriving = b"x"
    turns(server)
    assert (broken.aborted, sound.closed) == (True, False)
    assert [piece for _, piece in GIVEN] == [b"x"]


def test_what_was_read_of_a_client_that_is_gone_is_forgotten() -> None:
    server = Server()
    lines = [dial(server) for _ in range(50)]
    for line in lines:
        line.arriving = b"x" * 1000
    server.loop.turn()
    for line in lines:
        line.lose()
    before = len(GIVEN)
    turns(server)
    assert len(GIVEN) == before


def test_a_turn_is_asked_for_only_while_something_comes() -> None:
    asked: list[Callable[[], None]] = []
    intake = Intake(asked.append)

    class Once:
        def parse(self) -> int:
            return 1

    intake.put("a", Once().parse)
    intake.work()
    assert len(asked) == 1
    asked.pop()()
    assert asked == []
