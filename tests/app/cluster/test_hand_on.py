"""What a request is of, read from its path and its body; and a body that is read again."""

import asyncio

import pytest
from app.cluster.body import Body
from app.cluster.line import MOST_HOPS
from starlette.types import Message

from app.cluster.hand_on import hops_of, room_of_body, room_of_path
from tests.waiting import LIMIT


@pytest.mark.parametrize(
    ("path", "room"),
    [
        ("/api/v1/rooms/main", "main"),
        ("/api/v1/rooms/main/drops", "main"),
        ("/api/v1/rooms/a b/log", "a b"),
        ("/ws/rooms/classic", "classic"),
        ("/api/v1/rooms", None),
        ("/api/v1/rooms/", None),
        ("/api/v1/drops/classic/1", None),
        ("/", None),
    ],
)
def test_a_path_says_of_which_room_it_is(path: str, room: str | None) -> None:
    assert room_of_path(path) == room


@pytest.mark.parametrize(
    ("body", "room"),
    [
        (b'{"room": "main", "halted": true}', "main"),
        (b'{"room": null, "halted": true}', None),
        (b'{"room": 3}', None),
        (b"[1]", None),
        (b"\xff", None),
        (b"", None),
    ],
)
def test_a_body_may_name_the_room(body: bytes, room: str | None) -> None:
    assert room_of_body(body) == room


@pytest.mark.parametrize(
    ("said", "hops"), [("0", 0), ("2", 2), ("3", MOST_HOPS), ("-1", MOST_HOPS), ("x", MOST_HOPS)]
)
def test_what_is_no_count_of_hops_is_the_last_one(said: str, hops: int) -> None:
    assert hops_of({"type": "http", "headers": [(b"plinko-hops", said.encode())]}) == hops


async def test_a_body_is_read_again_from_its_beginning_and_its_end_is_that_of_the_line() -> None:
    parts: list[Message] = [
        {"type": "http.request", "body": b"one ", "more_body": True},
        {"type": "http.request", "body": b"two", "more_body": False},
        {"type": "http.disconnect"},
    ]

    async def receive() -> Message:
        return parts.pop(0)

    body = Body(receive)
    first = body.again()
    assert (await first())["body"] == b"one "
    assert await body.whole() == b"one two"
    second = body.again()
    assert [(await second())["body"] for _ in range(2)] == [b"one ", b"two"]
    async with asyncio.timeout(LIMIT):
        await body.until_left()
