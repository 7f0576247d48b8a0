"""Who asked for an input of a room over REST or a socket, and waits to hear what becomes of it."""

import asyncio
from dataclasses import dataclass
from typing import Any, Self

from app.protocol import messages
from app.rooms.pending import Requester


@dataclass(frozen=True, kw_only=True)
class WaitingRequester(Requester):
    """A requester with the future that says what became of the input."""

    settled: "asyncio.Future[messages.Event | None]"

    @classmethod
    def now(cls, client: int | None, key: str, ref: Any, again: str | None) -> Self:
        """One that waits on the running event loop."""
        settled = asyncio.get_running_loop().create_future()
        return cls(client=client, key=key, ref=ref, again=again, settled=settled)

    def carried_out(self, event: messages.Event | None) -> None:
        """Hear the first event that came of the input, if any did."""
        if not self.settled.done():
            self.settled.set_result(event)

    def refused(self, error: Exception) -> None:
        """Hear why the input will not be carried out."""
        if not self.settled.done():
            self.settled.set_exception(error)
