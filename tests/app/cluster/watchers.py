"""Clients that only watch, come back whenever their line ends, and note what they missed."""

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
"""The close code of a room that goes on elsewhere."""

_AGAIN: Final = 0.05  # s until one comes again that found nobody


@dataclass(frozen=True)
class Break:
    """A line that ended: when the room was last seen to move, and the next line greeted, in s.

    ticks: by how many the room had gone on meanwhile; vain: lines in between that greeted nobody.
    """

    last: float
    back: float
    ticks: int
    vain: int

    @property
    def gap(self) -> float:
        """For how long nothing moved, in s."""
        return self.back - self.last


@dataclass
class Pulse:
    """A room, as those who watch it see it move."""

    seen: float = 0.0  # when one of them last was shown something, in s
    tick: int = 0  # which that was


@dataclass
class Watcher:
    """ServerProcess of them, in one room.

    Most watch as pages do, who are told of drops and compute the rest; one in each room is sent
    every tick, and knows for all of them until when it moved.
    """

    room: str
    pulse: Pulse
    stream: str = "seeds"
    tick: int = 0
    last: float = 0.0  # when it was last shown that the room moves; 0: never
    breaks: list[Break] = field(default_factory=list)
    codes: Counter[int | None] = field(default_factory=Counter)  # with which lines were closed
    vain: int = 0  # lines since the last greeting
    _lost: bool = False  # not greeted since a line ended
    _left: int = 0  # the tick at which it did

    async def watch(self, somewhere: Callable[[], ServerProcess]) -> None:
        """Watch until cancelled; raises AssertionError for a tick that is taken back."""
        while True:
            greeted = await self._line(somewhere())
            if greeted:
                self.last, self._left = self.pulse.seen, self.pulse.tick
            self._lost = True
            self.vain += not greeted
            # As a page: whoever is sent on comes at once, whoever finds nobody waits a little.
            await asyncio.sleep(0.0 if greeted else _AGAIN)

    async def _line(self, one: ServerProcess) -> bool:
        """Be there until the line ends; whether it greeted."""
        url, before = one.socket(self.room, f"?stream={self.stream}"), self.last
        with contextlib.suppress(*Broken):
            async with joining(url) as line:
                with contextlib.suppress(ConnectionClosed):
                    async for frame in line:
                        self.frame(frame)
                self.codes[line.close_code] += 1
        return self.last > before

    def frame(self, frame: str | bytes) -> None:
        """Take in what came."""
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


def taken_over(watchers: Iterable[Watcher], since: float, until: float) -> list[float]:
    """How long after `since` each room greeted again, in s, of those that lost all who watched."""
    rooms: dict[str, list[float | None]] = {}
    for each in watchers:
        backs = [one.back for one in each.breaks if since <= one.back < until]
        rooms.setdefault(each.room, []).append(min(backs, default=None))
    lost = ([back for back in found if back is not None] for found in rooms.values())
    whole = zip(rooms.values(), lost, strict=True)
    return [min(backs) - since for found, backs in whole if len(backs) == len(found)]


def spread(values: Sequence[float]) -> str:
    """How times are spread, in words."""
    if not values:
        return "none"
    ordered = sorted(values)
    middle, most = ordered[len(ordered) // 2], ordered[int(0.99 * (len(ordered) - 1))]
    return (
        f"{len(ordered)}, the median {middle:.2f} s, 99 of 100 up to {most:.2f} s, "
        f"the longest {ordered[-1]:.2f} s"
    )
