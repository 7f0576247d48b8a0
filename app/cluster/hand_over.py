"""Gives rooms of this server to others: one that is to be moved, or all when the server ends."""

import asyncio
import contextlib
import logging
from collections.abc import Callable
from typing import Final

from app.cluster.alive import Alive
from app.cluster.membership import Member, order
from app.cluster.peers import Peers
from app.errors import AppError, InvalidValueError, shorten
from app.live.shared_rooms import SharedRooms

_AT_ONCE: Final = 4
"""Rooms that nobody watches are handed over at a time: no more than a server brings back at a time.
Those that are watched go one by one: each stands still until the other server has it, and that is
the sooner, the less else that server has to do."""

_log = logging.getLogger("plinko")


class HandOver:
    """For the event loop's thread. `count` is of rooms; `watched` says how many watch a room."""

    def __init__(
        self, alive: Alive, rooms: SharedRooms, peers: Peers, watched: Callable[[str], int]
    ) -> None:
        self.count = 0
        self._alive = alive
        self._rooms = rooms
        self._peers = peers
        self._watched = watched

    async def move(self, room_id: str, to: str) -> Member:
        """Give a room that is here to the server of this name; raises InvalidValueError."""
        target = self._alive.view.named(to)
        if target is None:
            names = ", ".join(sorted(each.name for each in self._alive.view.members.values()))
            raise InvalidValueError(f"to={shorten(to)} is no server: there are {names}", field="to")
        if target.holder != self._alive.me.holder:
            await self._give(room_id, target)
        return target

    async def leave(self) -> None:
        """Give all rooms to the others, each from the very tick at which it is; then be gone."""
        await self._alive.leave()
        if others := self._alive.others:
            rooms = self._rooms.leases.book.rooms
            watched = list(filter(self._watched, rooms))
            await self._give_all([each for each in rooms if each not in watched], others, _AT_ONCE)
            await self._give_all(watched, others, 1)
        await self._rooms.leaving.hand_all_over()
        await self._peers.end_sockets()

    async def _give_all(self, rooms: list[str], others: list[Member], at_once: int) -> None:
        turns = asyncio.Semaphore(at_once)

        async def give(room_id: str) -> None:
            async with turns:
                with contextlib.suppress(AppError):
                    await self._give(room_id, order(room_id, others)[0])

        await asyncio.gather(*map(give, rooms))

    async def _give(self, room_id: str, target: Member) -> None:
        await self._rooms.leaving.hand_over(
            room_id,
            lambda: self._peers.have_taken(target, room_id),
            holder=target.holder,
            address=target.address,
        )
        self.count += 1
        _log.info("room handed over", extra={"room": room_id, "to": target.name})
