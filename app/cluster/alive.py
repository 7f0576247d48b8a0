"""Says that this server is alive, sees which others are, and wakes whoever waits for that."""

import asyncio
import contextlib
import logging
import time
from collections.abc import Callable

from app.cluster.beats import FAILURES, Beats
from app.cluster.membership import BEAT, LEASE, Member, View
from app.concurrency.signal import Signal
from app.persistence.holds import Holds

_log = logging.getLogger("plinko")


class Alive:
    """For the event loop's thread. `run` while anything is asked of it."""

    def __init__(
        self, beats: Beats, holds: Holds, name: str, *, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.name = name
        self.view = View()
        self.leaving = False
        self.missed = Signal()  # somebody is gone
        self._beats = beats
        self._holds = holds
        self._clock = clock
        self._looked = Signal()  # at who is alive, with whatever came of it
        self._seen: set[str] = set()  # who was alive at the last look
        self._beaten = clock()
        self._doubtful = False

    @property
    def me(self) -> Member:
        """This server, as the others see it."""
        return Member(self._holds.holder, self.name, self._holds.address, self.leaving)

    @property
    def joined(self) -> bool:
        """Whether the others know that this server is there."""
        return self._holds.holder in self.view.members

    @property
    def others(self) -> list[Member]:
        """The other servers that can be given rooms."""
        return self.view.others(self._holds.holder)

    @property
    def doubtful(self) -> bool:
        """Whether others may have taken rooms of this server, which they did not hear of."""
        return self._doubtful or not self.view.up

    def checked(self) -> None:
        """Rooms that others have taken are known now."""
        self._doubtful = False

    async def run(self) -> None:
        """Beat until cancelled, whatever becomes of it; at once where another server leaves."""
        while True:
            due = self._clock() + BEAT
            await self.beat()
            with contextlib.suppress(*FAILURES):
                await self._beats.until_told(max(0.0, due - self._clock()))
            if not self.view.up:
                await asyncio.sleep(max(0.0, due - self._clock()))

    async def beat(self) -> None:
        """Say that this server is alive, and see who else is."""
        try:
            look = await self._beats.beat(self.me)
        except FAILURES as error:
            if self.view.up:
                _log.warning("servers do not see each other: rooms stay where they are: %s", error)
            self.view.failed()
            self._looked.send()
            return
        now = self._clock()
        self._doubtful = self._doubtful or now - self._beaten > LEASE
        self._beaten = now
        self.view.look(now, look)
        before, self._seen = self._seen, set(self.view.members)
        self._looked.send()
        if before - self._seen:
            self.missed.send()

    async def until_looked(self) -> None:
        """Return once it was looked again at who is alive, or that could not be seen."""
        await self._looked.wait()

    async def until_gone(self, member: Member) -> None:
        """Return when this server is gone."""
        while not self.view.is_gone(member.holder):
            await self.missed.wait()

    async def gone(self) -> None:
        """This server has ended; nobody is to ask it any more."""
        with contextlib.suppress(*FAILURES):
            await self._beats.leave(self.me)
        self._beats.close()
