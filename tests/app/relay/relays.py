"""A relay of the tests' own, in a thread, on a free port of the loopback."""

import contextlib
import threading
from collections.abc import Iterator
from dataclasses import dataclass

import uvicorn

from app.listening import config_over, listen
from app.relay.redis_at import redis_at
from app.relay.served import create_relay
from app.relay.spectators import Spectators
from app.settings import Settings
from app.web.edge.addresses import Connections, Proxies
from tests.app.relay.redis import Redis
from tests.waiting import until


@dataclass(frozen=True)
class Relayed:
    """A running relay."""

    url: str
    here: Spectators

    def socket(self, room: str = "main", query: str = "?stream=seeds&watch=true") -> str:
        return f"ws{self.url.removeprefix('http')}/ws/rooms/{room}{query}"


@contextlib.contextmanager
def relaying(redis: Redis, rooms: str) -> Iterator[Relayed]:
    """Run a relay for the server at `rooms` until the block ends."""
    settings = Settings(port=0)
    app = create_relay(settings, redis_at(redis.url), rooms)
    config = config_over(app, settings, Connections(500, Proxies(())), app.state.refused)
    with listen(settings) as listener:
        server = uvicorn.Server(config)
        thread = threading.Thread(target=server.run, args=([listener],), name="relay")
        thread.start()
        try:
            until(lambda: server.started)
            yield Relayed(f"http://127.0.0.1:{listener.getsockname()[1]}", app.state.spectators)
        finally:
            server.should_exit = True
            thread.join()
