"""How rooms come back from the ledger: all that moved at the start, one that sleeps when needed."""

import asyncio
import functools
import logging
import math
from dataclasses import replace
from typing import Final

from app.errors import LedgerError
from app.persistence import store
from app.persistence.rebuild import Rebuilt, Taken, finish, rebuild
from app.persistence.sessions import SessionRecord, Sessions
from app.rooms.kinds import BallLimits, format_of, ground_of, make_room, most_balls
from app.rooms.records import Close, Parked, RoomRow
from app.rooms.room import Ground, Room
from engine import PHYSICS_VERSION

_LONGEST_FALL: Final = 3600.0  # s of simulation to finish a room that cannot go on

_log = logging.getLogger("plinko")


class Recovery:
    """Makes rooms again from the ledger's rows; for the event loop's thread."""

    def __init__(self, sessions: Sessions, *, tick_rate: int, limits: BallLimits) -> None:
        self.rebuilt = 0  # rooms in which something moved
        self._sessions = sessions
        self._ledger = sessions.ledger
        self._tick_rate = tick_rate
        self._limits = limits

    async def resume(self) -> list[Room]:
        """The rooms in which something moved when the last server ended, as they were.

        Raises LedgerError when the ledger cannot be read.
        """
        self._sessions.next_number = await self._ledger.read(store.last_number) + 1
        rooms = []
        for row in await self._ledger.read(store.awake_rooms):
            try:
                room = await self._resume(row)
            except LedgerError:
                raise
            except Exception as error:  # noqa: BLE001
                # One room's fault must not keep the others closed. Its rows stay in the ledger.
                _log.exception("room cannot be rebuilt", extra={"room": row.id})
                self._retire(row, f"it cannot be rebuilt: {error}")
                continue
            if room is not None:
                rooms.append(room)
        return rooms

    async def public(self) -> dict[str, RoomRow]:
        """The public rooms that the ledger knows, by id."""
        return {row.id: row for row in await self._ledger.read(store.public_rooms)}

    async def parked(self) -> list[Parked]:
        """The open rooms with owners that the ledger knows, the longest unused first."""
        return await self._ledger.read(store.parked_rooms)

    async def load(self, room_id: str) -> Room | None:
        """A room that sleeps in the ledger, or None when it knows no such open room.

        Raises LedgerError when it cannot be read.
        """
        row = await self._ledger.read(functools.partial(store.open_room, room_id=room_id))
        if row is None:
            return None
        return await (self._migrate(row) if self._outdated(row) else self._resume(row))

    def restore(self, row: RoomRow, ground: Ground) -> Room | None:
        """A sleeping public room from its row; None when its session cannot go on."""
        why = self._outdated(row)
        if why is None and row.board != ground.digest:
            why = "its board is another now"
        if why is not None:
            self._retire(row, why)
            return None
        return self._enter(row, rebuild(row, ground, (), limits=self._limits))

    async def _resume(self, row: RoomRow) -> Room | None:
        """A session's room, or None when it could not go on and was brought to an end."""
        why = self._outdated(row)
        if why is not None and not format_of(row.mode).has_results:
            self._retire(row, why)
            return None
        ground, taken = await self._ground(row), await self._taken(row)
        if why is not None and row.physics_version != PHYSICS_VERSION:
            self._void(row, taken, why)
            self._retire(row, why)
            return None
        rebuilt = await asyncio.to_thread(rebuild, row, ground, taken, limits=self._limits)
        for difference in rebuilt.differences:
            _log.error("a result is not reproduced: %s", difference, extra={"room": row.id})
        if why is not None:
            await asyncio.to_thread(finish, rebuilt, math.ceil(_LONGEST_FALL * row.tick_rate))
            self._sessions.add_results(rebuilt.results)
            self._retire(replace(row, tick=rebuilt.room.world.tick), why)
            return None
        self.rebuilt += row.awake
        return self._enter(row, rebuilt)

    async def _taken(self, row: RoomRow) -> Taken:
        """The inputs since the checkpoint, and those before whose results are still of use."""
        inputs = format_of(row.mode)
        first = inputs.first_needed(row.checkpoint_drops, most_balls(row.mode, self._limits))
        return await self._ledger.read(
            functools.partial(store.taken, name=inputs.name, room=row.number, first=first)
        )

    def _void(self, row: RoomRow, taken: Taken, why: str) -> None:
        """End what can no longer be computed as it was promised."""
        inputs = format_of(row.mode)
        void = (inputs.void(each, row.tick, why) for each, result in taken if result is None)
        self._sessions.add_results([each for each in void if each is not None])

    def _enter(self, row: RoomRow, rebuilt: Rebuilt) -> Room:
        room = rebuilt.room
        self._sessions.add_results(rebuilt.results)
        record = SessionRecord(
            number=row.number,
            owned=row.owned,
            opened=row.opened,
            used=row.used,
            known=True,
            marked=row.tick,
            horizon=row.tick,
            checkpoint_tick=room.world.tick,
            clean=not row.awake,
        )
        self._sessions.begin(row.id, record)
        if row.awake and not room.awake:
            self._sessions.slept(room)
        return room

    def _outdated(self, row: RoomRow) -> str | None:
        """Why a session cannot go on in this server, or None when it can."""
        if row.physics_version != PHYSICS_VERSION:
            return f"its physics was version {row.physics_version}, now it is {PHYSICS_VERSION}"
        if row.tick_rate != self._tick_rate:
            return f"it ran at {row.tick_rate} Hz, the server now at {self._tick_rate} Hz"
        return None

    def _retire(self, row: RoomRow, why: str) -> None:
        _log.warning("room starts anew: %s", why, extra={"room": row.id})
        self._sessions.report([Close(row.number, row.tick, self._sessions.now())])

    async def _migrate(self, row: RoomRow) -> Room:
        """The same room in a new session, as the old one cannot go on."""
        ground = await self._ground(row)
        if row.awake:
            await self._resume(row)
        else:
            self._retire(row, self._outdated(row) or "")
        room = make_room(row.id, ground, row.mode, tick_rate=self._tick_rate, limits=self._limits)
        record = self._sessions.of(room)
        record.owned, record.opened, record.known = row.owned, row.opened, True
        await self._ledger.commit(
            *self._sessions.rows(room, record), undo=(Close(record.number, 0, row.used),)
        )
        return room

    async def _ground(self, row: RoomRow) -> Ground:
        text = await self._ledger.read(functools.partial(store.board, digest=row.board))
        if text is None:
            raise LedgerError(f"the ledger lacks board {row.board}")
        return await asyncio.to_thread(ground_of, row.mode, text)
