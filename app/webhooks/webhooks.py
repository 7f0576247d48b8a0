"""All targets of a server's webhooks: started and stopped together."""

import asyncio
from collections.abc import Callable, Iterator, Sequence

import httpx

from plinko.app.ops.metrics import Reading
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.webhooks.sender import PATIENCE, Sender
from plinko.app.webhooks.targets import Target, names_of
from plinko.app.webhooks.transport import Transport


class Webhooks:
    """One sender for each target, for the event loop's thread; `mine` as in `Sender`."""

    def __init__(self, targets: Sequence[Target], ledger: Ledger, mine: Callable[[], bool]) -> None:
        # The client follows no redirects and ignores proxies in the environment.
        self._http = httpx.AsyncClient(transport=Transport(), timeout=PATIENCE, trust_env=False)
        self._senders = [
            Sender(target, ledger, self._http, name=name, mine=mine)
            for name, target in zip(names_of(targets), targets, strict=True)
        ]

    async def run(self) -> None:
        """Send to all targets until cancelled, side by side."""
        async with self._http, asyncio.TaskGroup() as tasks:
            for sender in self._senders:
                tasks.create_task(sender.run())

    def readings(self) -> Iterator[Reading]:
        text = "Age of the oldest event that a target has not accepted; 0 if none waits."
        for sender in self._senders:
            yield "plinko_webhook_oldest_seconds", text, sender.age, {"target": sender.name}
