"""The one module that knows uvicorn's WebSocket connection from inside: closing a stalled client.

ASGI lets an application send a close frame only when the write buffer has room, which the buffer of
a client that stopped reading never has. Under this protocol class the connection's scope carries an
extension, `plinko.sever`, that lets one last frame past the full buffer and gives the connection up
some seconds later. Without the extension (another server) `sever` does nothing and the close waits
for the client, bounded by the caller's timeout.
"""

import asyncio
from collections.abc import MutableMapping
from typing import Any

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

EXTENSION = "plinko.sever"


class Connection(WebSocketsSansIOProtocol):
    """uvicorn's connection, with a way out of a full write buffer."""

    async def run_asgi(self) -> None:
        """Run the application with `plinko.sever` among the scope's extensions."""
        extensions: Any = self.scope["extensions"]
        extensions[EXTENSION] = self._sever
        await super().run_asgi()

    def _sever(self, linger: float) -> None:
        self.writable.set()
        asyncio.get_running_loop().call_later(linger, self.transport.abort)


def sever(scope: MutableMapping[str, Any], linger: float) -> None:
    """Let one more frame out and drop the connection after `linger` seconds."""
    let_go = scope.get("extensions", {}).get(EXTENSION)
    if let_go is not None:
        let_go(linger)
