"""Sends a target the events that it has not received, in order, until it answers 2xx.

A request without such an answer is sent again, after longer and longer pauses, without end. So a
target receives every event at least once, unless `retention` deletes its drop before. If the server
ends after a target has answered but before the ledger has recorded it, the event is sent again
after the next start. A target recognizes repeated events by their ids.
"""

import asyncio
import base64
import hashlib
import hmac
import logging
import time
from collections.abc import Awaitable, Callable, Iterator, Sequence
from typing import Final

import httpx
import msgspec

from plinko.app.errors import LedgerError
from plinko.app.ops.metrics import Reading
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.persistence.statements import webhook_store
from plinko.app.persistence.statements.webhook_store import LANDED, Labels
from plinko.app.webhooks.targets import Target, names_of
from plinko.app.webhooks.transport import Transport
from plinko.engine.json_text import Json, JsonObject

MOST_BOARDS: Final = 64  # boards whose labels are cached between requests
MOST: Final = 100  # events in a request
LOOK: Final = 0.2  # s between polls of the ledger while no events wait
FIRST, LONGEST = 1.0, 60.0  # s between tries: doubled from the first to the longest
PATIENCE: Final = 10.0  # s in which a target must answer

_log = logging.getLogger("plinko")


class Sender:
    """Sends to one target, called `name` in logs and metrics; for the event loop's thread.

    Where several servers share the ledger, only the one whose `mine` returns True sends.
    """

    def __init__(
        self,
        target: Target,
        ledger: Ledger,
        http: httpx.AsyncClient,
        *,
        name: str = "",
        mine: Callable[[], bool] = lambda: True,
        now: Callable[[], float] = time.time,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
        patience: float = PATIENCE,
    ) -> None:
        self.target = target
        self.name = name or target.host
        self._ledger = ledger
        self._http = http
        self._mine = mine
        self._now = now
        self._sleep = sleep
        self._patience = patience
        self._failing = False
        self._oldest: float | None = None  # Unix time of the oldest event that waits
        self._labels: dict[str, webhook_store.Labels] = {}  # by board

    @property
    def age(self) -> float:
        """Seconds since the oldest event that waits; 0 if none waits."""
        return 0.0 if self._oldest is None else max(0.0, self._now() - self._oldest)

    async def run(self) -> None:
        """Send until cancelled."""
        followed = False
        while True:
            try:
                if not followed:
                    await self._follow()
                    followed = True
                waited = self._mine() and await self._send_waiting()
                if not waited:
                    self._oldest = None
            except LedgerError:  # the ledger has logged it
                waited = False
            except Exception:  # noqa: BLE001 - one target must not end the others
                _log.exception("webhook %s: cannot send events; trying again", self.name)
                await self._sleep(LONGEST)
                continue
            if not waited:
                await self._sleep(LOOK)

    async def _send_waiting(self) -> bool:
        """Send one request with waiting events; False if no event waits. Raises LedgerError."""
        read = self._ledger.read
        found = await read(webhook_store.waiting, target=self.target.url, most=MOST)
        rows = found.events
        if not rows:
            return False
        self._oldest = rows[0]["time"]
        if len(self._labels) >= MOST_BOARDS:
            self._labels.clear()
        for board in {row["board"] for row in rows} - self._labels.keys():
            self._labels[board] = await read(webhook_store.labels, board=board)
        await self._deliver(rows)
        await self._ledger.commit(*found.cursors)
        return True

    async def _follow(self) -> None:
        """Begin to follow runs that began without this target; raises LedgerError."""
        new = await self._ledger.read(webhook_store.follow, target=self.target.url)
        if new:
            await self._ledger.commit(*new)

    async def _deliver(self, rows: Sequence[JsonObject]) -> None:
        """Send these events in one request, again and again until the target confirms it."""
        events = [event_of(row, self._labels[row["board"]]) for row in rows]
        body, message = body_of(events), f"{events[0]['id']}-{events[-1]['id']}"
        delay = FIRST
        while (fault := await self._try(message, body)) is not None:
            if not self._failing:
                _log.warning("webhook %s: %s; trying again", self.name, fault)
            self._failing = True
            await self._sleep(delay)
            delay = min(2.0 * delay, LONGEST)
        if self._failing:
            _log.warning("webhook %s accepts events again", self.name)
            self._failing = False

    async def _try(self, message: str, body: bytes) -> str | None:
        """Send one request; return None if the target confirms it, else the reason."""
        headers = signed(self.target.key, message, int(self._now()), body)
        try:
            async with asyncio.timeout(self._patience):
                answer = await self._http.post(self.target.url, content=body, headers=headers)
        except (httpx.HTTPError, TimeoutError) as error:
            return str(error) or type(error).__name__
        return None if answer.is_success else f"it answered {answer.status_code}"


_ALWAYS: Final = ("tick", "seed", "x", "stake")
_OPTIONAL: Final = ("aim", "who", "name", "colour")
_RESULT: Final = ("tick", "bin", "score", "payout", "t", "x_end", "digest", "unsettled")


def event_of(row: JsonObject, labels: Labels) -> dict[str, object]:
    """One event, from its row in the ledger; sent again, it has the same `id`.

    `labels` are those of the board's bins, or empty. In the event `seed` is decimal text, and
    `tick` is the tick of the ball's start or landing. Lengths are in m, times in s, money in minor
    units. `room` is the room's id, `run` the number of its run.
    """
    landed = row["event"] == LANDED
    event: dict[str, Json] = {
        "id": f"{row['room']}.{row['ball']}.{row['event']}",
        "type": row["event"],
        "room": row["room_id"],
        "run": row["room"],
        "ball": row["ball"],
        "board": row["board"],
    }
    event |= {name: row[name] for name in _ALWAYS} | {"seed": str(row["seed"])}
    event |= {name: row[name] for name in _OPTIONAL if row.get(name) is not None}
    if row["practice"]:
        event["practice"] = True
    if landed:
        event |= {name: row[f"result_{name}"] for name in _RESULT}
        if labels and event["bin"] is not None and (label := labels[event["bin"]]) is not None:
            event["label"] = label
    return event


def body_of(events: Sequence[JsonObject]) -> bytes:
    return msgspec.json.encode({"events": events})


def signed(key: bytes, message: str, timestamp: int, body: bytes) -> dict[str, str]:
    """The headers that prove to a target who sent this body, and when (Unix time).

    They follow https://www.standardwebhooks.com, which has libraries in many languages. `message`
    is the request's id.
    """
    whole = f"{message}.{timestamp}.".encode() + body
    code = base64.b64encode(hmac.digest(key, whole, hashlib.sha256)).decode()
    return {
        "content-type": "application/json",
        "webhook-id": message,
        "webhook-timestamp": str(timestamp),
        "webhook-signature": f"v1,{code}",
    }


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
