"""Spectators that reconnect when their connection ends, and record each interruption."""

import asyncio
import contextlib
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Final

from websockets.exceptions import ConnectionClosed

from tests.kit.player import events_of, joining, tick_of
from tests.kit.process import ServerProcess
from tests.kit.siege import Broken

SENT_ON: Final = 1012
"""The close code of a room that moved to another server."""

_AGAIN: Final = 0.05  # s between two attempts to connect


@dataclass(frozen=True)
class Break:
    """An interruption of one client.

    last: when a spectator of the room last saw it move, s; back: when the next connection showed
    it, s; ticks: by how many the room had advanced; vain: connections in between without a hello.
    """

    last: float
    back: float
    ticks: int = 0
    vain: int = 0

    @property
    def gap(self) -> float:
        """Seconds without a picture."""
        return self.back - self.last


@dataclass
class Pulse:
    """The newest state of a room that any of its spectators has received."""

    seen: float = 0.0  # when it came, s
    tick: int = 0  # its tick


@dataclass
class Watcher:
    """A spectator of one room.

    Most use the stream `seeds`, as pages do. One in each room receives every tick; its `pulse`
    tells all of them until when the room moved.
    """

    room: str
    pulse: Pulse
    stream: str = "seeds"
    tick: int = 0
    last: float = 0.0  # when it last received a tick, s; 0: never
    breaks: list[Break] = field(default_factory=list)
    codes: Counter[int | None] = field(default_factory=Counter)  # close codes of its connections
    vain: int = 0  # connections since the last hello
    _lost: bool = False  # its connection ended, and no hello came since
    _left: int = 0  # the room's tick at that end

    async def watch(self, somewhere: Callable[[], ServerProcess]) -> None:
        """Watch until cancelled; raises AssertionError if an earlier tick follows a later one."""
        while True:
            greeted = await self._line(somewhere())
            if greeted:
                self.last, self._left = self.pulse.seen, self.pulse.tick
            self._lost = True
            self.vain += not greeted
            # As a page does: reconnect at once after a move, but pause after a failed attempt.
            await asyncio.sleep(0.0 if greeted else _AGAIN)

    async def _line(self, one: ServerProcess) -> bool:
        """Watch until the connection ends; returns whether a tick came."""
        url, before = one.socket(self.room, f"?stream={self.stream}"), self.last
        with contextlib.suppress(*Broken):
            async with joining(url) as line:
                with contextlib.suppress(ConnectionClosed):
                    async for frame in line:
                        self.frame(frame)
                self.codes[line.close_code] += 1
        return self.last > before

    def frame(self, frame: str | bytes) -> None:
        if isinstance(frame, bytes):
            self._seen(tick_of(frame))
            return
        for event in events_of(frame):
            if event["type"] in ("hello", "clock"):
                self._seen(event["tick"])

    def _seen(self, tick: int) -> None:
        assert tick >= self.tick, "a tick that was shown was taken back"
        now = time.monotonic()
        if self.last and self._lost:
            self.breaks.append(Break(self.last, now, tick - self._left, self.vain))
        self.tick = tick
        self.pulse.tick = max(tick, self.pulse.tick)
        self.last = self.pulse.seen = now
        self._lost, self.vain = False, 0


def failed_over(watchers: Iterable[Watcher], since: float, until: float) -> list[float]:
    """Seconds from `since` until each room that lost all its spectators showed itself again."""
    rooms: dict[str, list[float | None]] = {}
    for each in watchers:
        backs = [one.back for one in each.breaks if since <= one.back < until]
        rooms.setdefault(each.room, []).append(min(backs, default=None))
    lost = ([back for back in found if back is not None] for found in rooms.values())
    whole = zip(rooms.values(), lost, strict=True)
    return [min(backs) - since for found, backs in whole if len(backs) == len(found)]


def spread(values: Sequence[float]) -> str:
    """Count, median, 99th percentile and maximum of times, in words."""
    if not values:
        return "none"
    ordered = sorted(values)
    middle, most = ordered[len(ordered) // 2], ordered[int(0.99 * (len(ordered) - 1))]
    return (
        f"{len(ordered)}, the median {middle:.2f} s, 99 of 100 up to {most:.2f} s, "
        f"the longest {ordered[-1]:.2f} s"
    )
