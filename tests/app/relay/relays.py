"""A private relay for a test, in a thread, on a free port of the loopback."""

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass

import uvicorn

from plinko.app.listening import config_over, listen
from plinko.app.relay.bus import redis_at
from plinko.app.relay.served import create_relay
from plinko.app.relay.spectators import Spectators
from plinko.app.settings import Settings
from plinko.app.web.edge.addresses import Connections, Proxies
from tests.kit.address import Address
from tests.kit.redis import Redis
from tests.kit.serving import constants, in_thread
from tests.kit.waiting import LIMIT


@dataclass(frozen=True)
class Relayed(Address):
    url: str
    here: Spectators

    def socket(self, room: str = "main", query: str = "?stream=seeds&watch=true") -> str:
        return super().socket(room, query)


@contextlib.contextmanager
def relaying(redis: Redis, rooms: str) -> Iterator[Relayed]:
    """Run a relay for the server at `rooms` until the block ends."""
    settings = Settings(port=0)
    app = create_relay(settings, redis_at(redis.url), rooms)
    config = config_over(app, settings, Connections(500, Proxies(())), app.state.refused)
    # A busy server answers late: the relay must not give its clients away for that.
    patient = {"plinko.app.relay.replica.PATIENCE": LIMIT, "plinko.app.relay.replica.GONE": LIMIT}
    with constants(**patient), in_thread(uvicorn.Server(config), listen(settings)) as url:
        yield Relayed(url, app.state.spectators)
