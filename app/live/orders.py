"""What the operator has ordered: halted rooms, bans, and an announcement to all players.

Each order is committed to the ledger before the request is answered. The ledger keeps all of them,
as a log for auditors; what is in force follows from the log, also after a restart.
"""

import asyncio
import logging
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Final

from plinko.app.errors import BannedError, DamagedRoomError, HaltedError, LedgerError
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.persistence.statements import store
from plinko.app.rooms.records import EVERY_ROOM, Order

HALT: Final = "halt"
RELEASE: Final = "release"
ANNOUNCE: Final = "announce"
BAN: Final = "ban"
UNBAN: Final = "unban"

_KINDS: Final = {HALT: HALT, RELEASE: HALT, ANNOUNCE: ANNOUNCE, BAN: BAN, UNBAN: BAN}
"""The orders that stay in force, each with the kind of order that it begins or ends."""

_OVERLAP: Final = 100  # orders that are read again: servers may commit theirs out of order

_log = logging.getLogger("plinko")


class Orders:
    """For the event loop's thread. `tell` informs the clients; `now` returns Unix time in s."""

    def __init__(
        self,
        ledger: Ledger,
        tell: Callable[[], None],
        now: Callable[[], float] = time.time,
    ) -> None:
        self._ledger = ledger
        self._tell_all = tell
        self._now = now
        self._in_force: dict[tuple[str, str], Order] = {}
        self._last = 0
        self._turn = asyncio.Lock()

    @property
    def since(self) -> dict[str, float]:
        """The start of each halt, in Unix time in s, by room id; EVERY_ROOM stands for all."""
        return {room: each.time for (kind, room), each in self._in_force.items() if kind == HALT}

    @property
    def notice(self) -> str | None:
        """The announcement that players see now."""
        found = self._in_force.get((ANNOUNCE, ""))
        return None if found is None else found.text

    def holds(self, room_id: str) -> bool:
        """Whether this room is halted, by itself or with all rooms."""
        return (HALT, room_id) in self._in_force or (HALT, EVERY_ROOM) in self._in_force

    def check(self, room_id: str) -> None:
        """Raise HaltedError if this room is halted."""
        if self.holds(room_id):
            raise HaltedError(
                f"the operator of this server has halted room {room_id!r}: it takes no drops now; "
                "balls in flight land and pay",
                field="room",
            )

    def check_banned(self, whom: str | None) -> None:
        """Raise BannedError if this address or `who` is banned."""
        found = self._in_force.get((BAN, whom)) if whom else None
        if found is None or found.until is None:
            return
        left = found.until - self._now()
        if left > 0.0:
            raise BannedError(
                f"the operator of this server has banned {whom!r} for {left:.0f} s more",
                field="who",
                retry_after=left,
            )

    async def load(self) -> None:
        """Read the orders at the server's start; raises LedgerError if they are unreadable."""
        try:
            self._apply(await self._ledger.read(store.orders))
        except DamagedRoomError as error:
            _log.error("the log of the operator's orders is damaged, none is in force: %s", error)

    async def follow(self) -> None:
        """Take over the orders given at other servers; raises LedgerError."""
        async with self._turn:
            after, before = max(0, self._last - _OVERLAP), dict(self._in_force)
            self._apply(await self._ledger.read(store.orders, after=after))
            if self._in_force != before:
                self._tell_all()

    async def give(
        self, action: str, subject: str = "", text: str | None = None, until: float | None = None
    ) -> None:
        """Give an order, and note it in the log; raises LedgerError, and then it has no effect."""
        order = Order(action, subject, self._now(), text, until)
        await self._ledger.decided(self._give(order))

    async def _give(self, order: Order) -> None:
        async with self._turn:
            before = dict(self._in_force)
            if order.action == HALT and (HALT, order.subject) in before:
                return
            if order.action == RELEASE and (HALT, order.subject) not in before:
                return
            if order.action in (HALT, BAN):
                self._apply([order])  # effective while the ledger commits it
            try:
                await self._ledger.commit(order)
            except LedgerError:
                self._in_force = before
                raise
            self._apply([order])
            _log.warning("the operator: %s", order.action, extra={"subject": order.subject})
            if self._in_force != before:
                self._tell_all()

    def _apply(self, orders: list[Order]) -> None:
        for order in orders:
            self._last = max(self._last, order.number)
            key = (_KINDS.get(order.action, ""), order.subject)
            if order.action in (RELEASE, UNBAN) or (order.action == ANNOUNCE and not order.text):
                self._in_force.pop(key, None)
            elif key[0]:
                self._in_force[key] = replace(order, number=0)
