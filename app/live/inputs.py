"""What is asked of a room: taken, kept in the ledger, and let in once it is durable."""

import asyncio
import functools
from collections.abc import Callable, Mapping
from typing import Any, cast

from app.errors import LedgerError, RepeatedError
from app.live.halts import Halts
from app.live.sessions.fair_session import FairSession, TakenDrop
from app.live.ticking.runner import Runner
from app.live.waiting_requester import WaitingRequester
from app.persistence.service import PersistenceService
from app.persistence.statements import store
from app.protocol import messages
from app.protocol.touching_messages import Change
from app.rooms.outcome import Outcome, outcome_of
from app.rooms.pending import DropCommand, PendingInput
from app.rooms.records import InputRow
from app.rooms.room import Room


class Inputs:
    """For the event loop's thread. `in_memory` has the rooms that are here, by id.

    `check_here` raises HoldLostError for a room that is going to another server; `draw` gives the
    seed of a drop that names none.
    """

    def __init__(
        self,
        persistence: PersistenceService,
        runner: Runner,
        halts: Halts,
        in_memory: Mapping[str, Room],
        *,
        check_here: Callable[[Room], None],
        draw: Callable[[], int],
    ) -> None:
        self._persistence = persistence
        self._runner = runner
        self._halts = halts
        self._in_memory = in_memory
        self._check_here = check_here
        self._draw = draw
        # Drops under way that may be asked for again, by room run and key.
        self._asked: dict[tuple[int, str], asyncio.Future[messages.Accepted]] = {}

    def drop(
        self,
        room: Room,
        seed: int | None,
        x: float | None,
        *,
        aim: float | None = None,
        stake: int = 0,
        who: str | None = None,
        session: FairSession | None = None,
        client: int | None = None,
        key: str = "",
        ref: Any = None,
        again: str | None = None,
    ) -> "asyncio.Future[messages.Accepted]":
        """Take a drop; once it is durable and its tick has come, it enters and the room is told.

        The future then has the event, whose `ref` goes to `client` alone, or the LedgerError in
        between. Raises HaltedError, BallLimitError, BusyError, LedgerError and the engine's errors.

        In a `session` the seed is that of its next drop, and its receipt is kept with the drop;
        also raises what `FairSession.check` raises, and InvalidValueError for a seed or an x.
        """
        self._check(room)
        self._runner.check_memory()
        practice = seed is not None or x is not None
        if session is not None:
            session.check(room, practice=practice)
            seed = session.next_seed()
        number = self._draw() if seed is None else seed
        command = DropCommand(number, x, stake, who, aim, practice=practice)
        request = WaitingRequester.now(client, key, ref, again)
        pending = room.plan_drop(command, self._persistence.lead, request)
        self._submit(room, pending, session)
        asked = cast("asyncio.Future[messages.Accepted]", request.settled)
        if again is not None:
            place = self._place(room, again)
            self._asked[place] = asked
            asked.add_done_callback(lambda _: self._asked.pop(place))
        return asked

    async def asked_before(self, room: Room, again: str) -> Outcome | None:
        """What came of the drop that bears this key, if there is one; raises what it raised.

        Also LedgerError, and RepeatedError where only the room's log can say.
        """
        place = self._place(room, again)
        if place not in self._asked:
            read = functools.partial(store.keyed, room=place[0], key=again)
            found = await self._persistence.ledger.read(read)
            if isinstance(found, InputRow):
                raise RepeatedError(
                    "a drop with this key was taken before: the room's log has it", field="key"
                )
            if found is not None:
                return outcome_of(room.ground, *found)
        if place not in self._asked:
            return None
        accepted = await self._persistence.ledger.decided(self._asked[place])
        return Outcome(accepted, None)

    def _place(self, room: Room, again: str) -> tuple[int, str]:
        return self._persistence.runs.of(room).number, again

    def change(
        self,
        room: Room,
        change: Change,
        *,
        client: int | None = None,
        key: str = "",
        ref: Any = None,
    ) -> "asyncio.Future[messages.Event | None]":
        """Take an input of a room whose balls touch each other, as `drop` takes a drop.

        The future has the first event that came of it, if any. Raises InvalidValueError,
        BallLimitError, HaltedError, LedgerError.
        """
        self._check(room)
        request = WaitingRequester.now(client, key, ref, None)
        self._submit(room, room.plan_change(change, self._persistence.lead, request))
        return request.settled

    def _check(self, room: Room) -> None:
        """Raise HaltedError, HoldLostError where nothing is taken now."""
        self._halts.check(room.id)
        self._check_here(room)

    def _submit(
        self, room: Room, pending: PendingInput[Any], session: FairSession | None = None
    ) -> None:
        taken = None
        if session is not None:
            number = self._persistence.runs.of(room).number
            taken = session.take(pending, number, self._persistence.now())
        done = functools.partial(self._kept, room, pending, taken)
        try:
            self._persistence.submit(room, pending, done, None if taken is None else taken.leaf)
        except LedgerError:
            if taken is not None:
                taken.settled(refused=True)
            room.refuse(pending)
            raise

    def _kept(
        self,
        room: Room,
        pending: PendingInput[Any],
        taken: TakenDrop | None,
        error: LedgerError | None,
    ) -> None:
        """A planned input is in the ledger, or will not be."""
        if taken is not None:
            pending.receipt = taken.settled(refused=error is not None)
        if self._in_memory.get(room.id) is not room:
            closed = f"room {room.id!r} was closed before the drop was kept"
            pending.requester.refused(error or LedgerError(closed))
        elif error is None:
            pending.durable = True
            self._runner.admit_now(room)
        else:
            room.refuse(pending)
            pending.requester.refused(error)
