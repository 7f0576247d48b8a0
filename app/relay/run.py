"""Runs a relay: its socket, uvicorn over it, and the line that says where it is."""

import gc
import socket

import uvicorn

from app.listening import address_of, listen, raise_files
from app.live.broadcast import transport
from app.ops import logs
from app.relay.redis_at import redis_at
from app.relay.served import create_relay
from app.settings import Settings
from app.web.edge.addresses import Proxies


class RelayServer(uvicorn.Server):
    """uvicorn's server, which says where it is once it can be used."""

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start, then leave what lives for good out of every later garbage collection."""
        await super().startup(sockets)
        gc.collect()
        gc.freeze()
        for listener in sockets or ():
            print(f"A relay of Plinko is at {address_of(listener)}", flush=True)  # noqa: T201


def run(settings: Settings, redis: str, rooms: str) -> None:
    """Serve until SIGINT or SIGTERM; raises SettingError when it cannot listen."""
    logs.configure(settings.log_level, settings.log_format)
    app = create_relay(settings, redis_at(redis), rooms)
    proxies = Proxies(settings.trusted_proxies)
    raise_files(settings)
    config = uvicorn.Config(
        app,
        loop="uvloop",
        http="httptools",
        ws=transport.protocol_class(transport.choose(settings.transport)),
        ws_per_message_deflate=False,
        ws_max_size=settings.max_message,
        access_log=False,
        log_config=None,
        server_header=False,
        proxy_headers=bool(proxies.names),
        forwarded_allow_ips=proxies.names,
        timeout_graceful_shutdown=settings.shutdown_grace,
    )
    with listen(settings) as listener:
        RelayServer(config).run(sockets=[listener])
