"""All targets of a server's webhooks: started and stopped together."""

import asyncio
from collections.abc import Callable, Iterator, Sequence

import httpx

from app.ops.metrics import Reading
from app.persistence.ledger.writer import Ledger
from app.webhooks.sender import PATIENCE, Sender
from app.webhooks.targets import Target


class Webhooks:
    """For the event loop's thread. `mine` says whether it is this server that sends."""

    def __init__(self, targets: Sequence[Target], ledger: Ledger, mine: Callable[[], bool]) -> None:
        # It follows no redirect, and goes by no proxy that the environment names.
        self._http = httpx.AsyncClient(timeout=PATIENCE, trust_env=False)
        self._senders = [Sender(target, ledger, self._http, mine=mine) for target in targets]

    async def run(self) -> None:
        """Send to all of them until cancelled: none waits for another."""
        async with self._http, asyncio.TaskGroup() as tasks:
            for sender in self._senders:
                tasks.create_task(sender.run())

    def readings(self) -> Iterator[Reading]:
        """For how long each target has taken nothing of what it is sent."""
        text = "Seconds since a target first failed to take what it is sent; 0 when it takes it."
        for sender in self._senders:
            yield "plinko_webhook_late_seconds", text, sender.late, {"target": sender.target.name}
