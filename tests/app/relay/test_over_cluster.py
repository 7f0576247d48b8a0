"""A relay's spectators stay connected when their room moves to another server."""

import signal
from typing import Any

import pytest

from plinko.engine import Board, drop
from tests.app.cluster.servers import Servers, member
from tests.app.cluster.test_servers import drop_at, move, new_room
from tests.app.conftest import QUICK
from tests.app.relay.relays import relaying
from tests.kit.player import playing
from tests.kit.postgres import PostgreSQL
from tests.kit.redis import MISSING, PROGRAM, Redis


def as_alone(landed: dict[str, Any], seed: int) -> bool:
    """Whether a ball landed as the engine alone computes it."""
    digest: str = drop(Board.from_json(QUICK), seed).digest
    return digest.startswith(landed["digest"])


@pytest.mark.postgresql
@pytest.mark.skipif(PROGRAM is None, reason=MISSING)
async def test_a_room_is_followed_between_servers_even_after_a_kill(
    postgresql: PostgreSQL,
) -> None:
    with Redis() as redis:
        relays = ("--relays", redis.url)
        first, second = member("relayed1", *relays), member("relayed2", *relays)
        both = Servers(postgresql.new_database(), (first, second))
        with both, relaying(redis, first.url) as relay:
            room = new_room(second, QUICK)
            async with playing(relay.socket(room)) as far:
                drop_at(second, room, 42)
                assert as_alone(await far.until("landed"), 42)
                assert move(room, first, ask=second).status_code == 200
                await far.until("hello")  # from the room's new server
                drop_at(second, room, 43)
                assert as_alone(await far.until("landed"), 43)
                first.end(signal.SIGKILL)
                new_hello = await far.until("hello")
                assert new_hello["stats"]["drops"] == 2
                drop_at(second, room, 44)
                assert as_alone(await far.until("landed"), 44)
                assert relay.here.lines == 0, "none needed its own connection to a server"
