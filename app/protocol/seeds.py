"""Text messages of `?stream=seeds`: what a client is told that computes each path itself. Pure.

There are no binary messages. A drop is told by its seed, or by its start where the seed does not
give it; a landing by the first digits of its digest, which say whether the client's path is the
room's. Between them a clock, from which the client knows which tick to show.
"""

from collections.abc import Iterable
from typing import Final

import msgspec

from app.protocol import messages
from engine.board.parts import DropZone
from engine.seeding import start_x

DIGITS: Final = 12
"""Of a landing's digest: of two paths that differ, one in 2^48 would pass for the other."""

_HELD: Final = 0.1
"""s that a landing may wait for company. Sending is what a client costs, and balls that land are
drawn from their paths, a few ticks later than they move in the room."""


class SeedStream:
    """What is told of one room, and when: `take` gives the events of the next message."""

    def __init__(self, tick_rate: int, tick: int, zone: DropZone) -> None:
        """`tick` is the room's now; in `zone` a seed says where its ball starts."""
        self._zone = zone
        self._patience = max(1, round(_HELD * tick_rate))  # ticks
        self._every = tick_rate  # ticks between two clocks
        self._landed: list[messages.Event] = []
        self._since = 0  # tick of the first that is held
        self._clock = tick  # that was told last

    def hold(self, events: Iterable[messages.Event], tick: int) -> None:
        """Keep what of a tick's events is told here: landings, and no contacts."""
        for event in events:
            if isinstance(event, messages.Contact):
                continue
            if not self._landed:
                self._since = tick
            self._landed.append(self.brief(event))

    def take(self, tick: int, seq: int, *, awake: bool) -> list[messages.Event]:
        """The events to tell at this tick, mostly none; all that are held once nothing moves.

        seq: room events announced so far.
        """
        late = awake and tick - self._clock >= self._every
        if awake and not late and not self._is_due(tick):
            return []
        told = self.release()
        if late:
            self._clock = tick
            told.append(messages.Clock(tick=tick, seq=seq))
        return told

    def release(self) -> list[messages.Event]:
        """The landings that are held: something is told that comes after them."""
        told, self._landed = self._landed, []
        return told

    def _is_due(self, tick: int) -> bool:
        return bool(self._landed) and tick - self._since >= self._patience

    def brief(self, event: messages.Event) -> messages.Event:
        """An event as it is told here: without what follows from the rest.

        Of a drop that was given up in flight nothing follows, and all is told.
        """
        if isinstance(event, messages.Accepted):
            middle = self._zone.x if isinstance(event.aim, msgspec.UnsetType) else event.aim
            by_seed = start_x(int(event.seed), middle, self._zone.jitter)
            return messages.BriefAccepted(
                ball=event.ball,
                seed=event.seed,
                tick=event.tick,
                x=None if event.x == by_seed else event.x,
                explicit_x=event.explicit_x,
                ref=event.ref,
                aim=event.aim,
                stake=event.stake,
                practice=event.practice,
                receipt=event.receipt,
                visitor=event.visitor,
                name=event.name,
                colour=event.colour,
            )
        if isinstance(event, messages.Landed) and event.digest is not None:
            digest = event.digest[:DIGITS]
            return messages.BriefLanded(ball=event.ball, digest=digest, payout=event.payout)
        return event
