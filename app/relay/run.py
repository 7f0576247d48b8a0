"""Runs a relay: opens its socket, starts uvicorn on it, and prints its address."""

import gc
import logging
import os
import socket

import uvicorn

from plinko.app.listening import config_over, listen, print_address, raise_files
from plinko.app.ops import logs
from plinko.app.relay.redis_at import redis_at
from plinko.app.relay.served import create_relay
from plinko.app.settings import Settings, not_settings
from plinko.app.web.edge.addresses import Connections, Proxies
from plinko.engine import __version__

_log = logging.getLogger("plinko")


class RelayServer(uvicorn.Server):
    """uvicorn's server, which prints its address when it is ready."""

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start, then exempt all long-lived objects from later garbage collections."""
        await super().startup(sockets)
        gc.collect()
        gc.freeze()
        for listener in sockets or ():
            print_address("A relay of Plinko is at", listener)
        _log.info("started", extra={"version": __version__})


def run(settings: Settings, redis: str, rooms: str) -> None:
    """Serve until SIGINT or SIGTERM; raises SettingError if it cannot listen."""
    logs.configure(settings.log_level, settings.log_format)
    for line in not_settings(os.environ):
        _log.warning(line)
    app = create_relay(settings, redis_at(redis), rooms)
    total = raise_files()
    # A relay stands behind a proxy, so all clients connect from the proxy's address. Trust every
    # proxy, and let one address open as many connections as all together.
    connections = Connections(total, Proxies(("0.0.0.0/0", "::/0")), total)
    config = config_over(app, settings, connections, app.state.refused)
    with listen(settings) as listener:
        RelayServer(config).run(sockets=[listener])
