"""Gives rooms of this server to others: one that is to be moved, or all when the server ends."""

import asyncio
import contextlib
import functools
import logging
import time
from collections.abc import Callable
from typing import Final

from app.cluster.alive import Alive
from app.cluster.line import Line
from app.cluster.membership import Member, order
from app.cluster.passed import Passed
from app.errors import AppError, InvalidValueError, shorten
from app.live.holding import Holding

_SENT: Final = 5.0
"""s for which the server that gave a room away knows whom it gave it to."""

_AT_ONCE: Final = 4
"""Rooms that nobody watches are handed over at a time: no more than a server brings back at a time.
Those that are watched go one by one: each stands still until the other server has it, and that is
the sooner, the less else that server has to do."""

_log = logging.getLogger("plinko")


class HandOver:
    """For the event loop's thread. `watched` says how many watch a room."""

    def __init__(
        self,
        alive: Alive,
        holding: Holding,
        line: Line,
        *,
        watched: Callable[[str], int],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.count = 0  # rooms
        self.passed = Passed()
        self._alive = alive
        self._holding = holding
        self._line = line
        self._watched = watched
        self._clock = clock
        self._sent: dict[str, tuple[Member, float]] = {}

    def sent_to(self, room_id: str) -> Member | None:
        """The server that was given a room a moment ago, if it is alive."""
        member, until = self._sent.get(room_id, (None, 0.0))
        if member is None or self._clock() >= until:
            return None
        return member if member.holder in self._alive.view.members else None

    async def move(self, room_id: str, to: str) -> Member:
        """Give a room that is here to the server of this name; raises InvalidValueError."""
        target = self._alive.view.named(to)
        if target is None:
            names = ", ".join(sorted(each.name for each in self._alive.view.members.values()))
            raise InvalidValueError(f"to={shorten(to)} is no server: there are {names}", field="to")
        if target.holder != self._alive.me.holder:
            await self._send(room_id, target)
        return target

    async def leave(self) -> None:
        """Give all rooms to the others, each from the very tick at which it is; then be gone."""
        self._alive.leaving = True
        await self._alive.beat()
        if others := self._alive.others:
            rooms = self._holding.holds.rooms
            watched = list(filter(self._watched, rooms))
            await self._send_all([each for each in rooms if each not in watched], others, _AT_ONCE)
            await self._send_all(watched, others, 1)
        await self._holding.hand_all_over()
        await self.passed.close()

    async def _send_all(self, rooms: list[str], others: list[Member], at_once: int) -> None:
        turns = asyncio.Semaphore(at_once)

        async def send(room_id: str) -> None:
            async with turns:
                with contextlib.suppress(AppError):
                    await self._send(room_id, order(room_id, others)[0])

        await asyncio.gather(*map(send, rooms))

    async def _send(self, room_id: str, target: Member) -> None:
        now = self._clock()
        self._sent = {room: sent for room, sent in self._sent.items() if sent[1] > now}
        self._sent[room_id] = (target, now + _SENT)
        taking = functools.partial(self._line.have_taken, target, room_id)
        await self._holding.hand_over(room_id, taking)
        self.count += 1
        _log.info("room handed over", extra={"room": room_id, "to": target.name})
