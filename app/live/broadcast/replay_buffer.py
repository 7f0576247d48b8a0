"""What was last announced in a room, for clients who lost their connection: bounded, pure."""

from collections import deque
from typing import Final

import msgspec

from app.protocol import messages

KEPT: Final = 256  # events; contacts are not among them, as nobody wants to hear a bounce late


class Recent:
    """The last acceptances and landings of one life of a room, under their numbers.

    `run` names that life: the numbers of another one mean nothing here.
    """

    def __init__(self, run: str) -> None:
        self.run = run
        self._events: deque[tuple[int, messages.Event, str, object]] = deque(maxlen=KEPT)
        self._lost = 0  # the number of the latest event that is not kept any more

    def begin(self, seq: int) -> None:
        """What came up to number `seq` was not heard here."""
        self._lost = max(self._lost, seq)

    def add(self, seq: int, event: messages.Event, key: str = "", ref: object = None) -> None:
        """Remember event number `seq`; its `ref` is for the client that has this key."""
        if isinstance(event, messages.Contact):
            return
        if len(self._events) == KEPT:
            self._lost = self._events[0][0]
        self._events.append((seq, event, key, ref))

    def since(self, run: str, seq: int, key: str, until: int) -> list[messages.Event] | None:
        """The events after number `seq` up to `until`; None when not all are known any more."""
        if run != self.run or seq < self._lost:
            return None
        return [
            _with_ref(event, ref) if key and key == owner else event
            for number, event, owner, ref in self._events
            if seq < number <= until
        ]


def _with_ref(event: messages.Event, ref: object) -> messages.Event:
    return msgspec.structs.replace(event, ref=ref)
