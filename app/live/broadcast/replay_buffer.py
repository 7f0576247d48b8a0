"""A bounded buffer of a room's last events, for clients that reconnect. Pure."""

from collections import deque
from typing import Final

import msgspec

from plinko.app.protocol import messages

KEPT: Final = 256  # events, without contacts: a late bounce interests no client


class Recent:
    """The last events of one room run by number, without contacts; `run` is its id."""

    def __init__(self, run: str) -> None:
        self.run = run
        self._events: deque[tuple[int, messages.Event, str, object]] = deque(maxlen=KEPT)
        self._lost = 0  # number of the latest event that the buffer no longer has

    def begin(self, seq: int) -> None:
        """Start after event number `seq`; earlier events are missing."""
        self._lost = max(self._lost, seq)

    def add(self, seq: int, event: messages.Event, key: str = "", ref: object = None) -> None:
        """Remember event number `seq`; only the client with this key gets the `ref`."""
        if isinstance(event, messages.Contact):
            return
        if len(self._events) == KEPT:
            self._lost = self._events[0][0]
        self._events.append((seq, event, key, ref))

    def since(self, run: str, seq: int, key: str, until: int) -> list[messages.Event] | None:
        """The events after number `seq` up to `until`; None if the buffer lacks some of them."""
        if run != self.run or seq < self._lost:
            return None
        return [
            _with_ref(event, ref) if key and key == owner else event
            for number, event, owner, ref in self._events
            if seq < number <= until
        ]


def _with_ref(event: messages.Event, ref: object) -> messages.Event:
    return msgspec.structs.replace(event, ref=ref)
