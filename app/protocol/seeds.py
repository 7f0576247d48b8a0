"""The text messages of the streams `paths` and `seeds`, whose clients know each path. Pure.

Neither sends contacts, and landings may wait for others. A clock in between tells the client which
tick to show. A client of `seeds` computes the paths itself: it is sent a drop as its seed, or with
its start if the seed does not determine it, and a landing as the first digits of its digest, by
which it checks its path.
"""

from collections.abc import Iterable
from typing import Final

import msgspec

from plinko.app.protocol import messages
from plinko.engine.board.parts import DropZone
from plinko.engine.seeding import start_x

DIGITS: Final = 12
"""Of a landing's digest, in hexadecimal: a wrong path passes for the right one once in 2^48."""

_DELAY: Final = 0.1
"""s that a landing may wait, so that one message has several landings: sending is the main cost of
a client. The wait is not seen, because the page draws balls a few ticks late anyway."""


class SparseStream:
    """Collects the events of one room; `take` returns those of the next message."""

    def __init__(self, tick_rate: int, tick: int) -> None:
        """`tick` is the room's current tick."""
        self._patience = max(1, round(_DELAY * tick_rate))  # ticks
        self._every = tick_rate  # ticks between two clocks
        self._landed: list[messages.Event] = []
        self._since = 0  # tick of the first landing that waits
        self._clock = tick  # tick of the last clock that was sent

    def form(self, event: messages.Event) -> messages.Event:
        """An event as this stream sends it."""
        return event

    def hold(self, events: Iterable[messages.Event], tick: int) -> None:
        """Add a tick's events, without contacts."""
        for event in events:
            if isinstance(event, messages.Contact):
                continue
            if not self._landed:
                self._since = tick
            self._landed.append(self.form(event))

    def take(self, tick: int, seq: int, *, awake: bool) -> list[messages.Event]:
        """The events to send at this tick, mostly none; all that wait if the room falls asleep.

        seq: number of the room's last event.
        """
        late = awake and tick - self._clock >= self._every
        if awake and not late and not self._is_due(tick):
            return []
        events = self.release()
        if late:
            self._clock = tick
            events.append(messages.Clock(tick=tick, seq=seq))
        return events

    def release(self) -> list[messages.Event]:
        """The landings that wait, to be sent before a later event."""
        landed, self._landed = self._landed, []
        return landed

    def _is_due(self, tick: int) -> bool:
        return bool(self._landed) and tick - self._since >= self._patience


class SeedStream(SparseStream):
    """The events of one room in their short forms."""

    def __init__(self, tick_rate: int, tick: int, zone: DropZone) -> None:
        """A seed draws its ball's start from `zone`."""
        super().__init__(tick_rate, tick)
        self._zone = zone

    def form(self, event: messages.Event) -> messages.Event:
        """An event in its short form, without the fields that the client can compute.

        The landing of a drop that was given up in flight cannot be computed; it stays complete.
        """
        if isinstance(event, messages.Accepted):
            middle = self._zone.x if isinstance(event.aim, msgspec.UnsetType) else event.aim
            by_seed = start_x(int(event.seed), middle, self._zone.jitter)
            known = {
                name: getattr(event, name) for name in messages.BriefAccepted.__struct_fields__
            }
            return messages.BriefAccepted(**known | {"x": None if event.x == by_seed else event.x})
        if isinstance(event, messages.Landed) and event.digest is not None:
            digest = event.digest[:DIGITS]
            return messages.BriefLanded(ball=event.ball, digest=digest, payout=event.payout)
        return event
