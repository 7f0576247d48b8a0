"""What those who watch a room are told: the state to start from, events, pictures, diagnostics."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import msgspec

from app.live.hub import Client, Hub
from app.live.replay_buffer import Recent
from app.protocol import messages
from app.protocol.wire import Frame
from app.rooms.independent import Room
from app.rooms.kinds import AnyRoom, ArenaRoom
from app.settings import Settings

_DIAGNOSED = 5  # times a second, for those who watch a room's diagnostics


@dataclass(frozen=True, slots=True)
class Giver:
    """Who asked for a drop or a change, and is told of it with the note it came with."""

    client: int | None
    key: str
    ref: Any


class Teller:
    """Sends by the hub what comes out of rooms, and remembers it for clients whose line broke."""

    def __init__(self, hub: Hub, settings: Settings, clock: Callable[[], float]) -> None:
        self._hub = hub
        self._clock = clock
        self._every = max(1, settings.tick_rate // _DIAGNOSED)  # ticks
        self._limits = messages.Limits(settings.max_balls, settings.drop_rate, settings.max_message)
        self._recent: dict[str, Recent] = {}
        self._curious: dict[str, set[int]] = {}  # clients that watch a room's diagnostics

    def begin(self, room: AnyRoom, run: str) -> None:
        """Begin to remember what is announced in this life of a room, whose name is `run`."""
        self._recent[room.id] = Recent(run)
        self._recent[room.id].begin(room.seq)

    def forget(self, room_id: str) -> None:
        """A room is not in memory any more."""
        self._recent.pop(room_id, None)

    def missed(self, room: AnyRoom, run: str, since: int, key: str) -> messages.Missed:
        """What a client with this key has missed after event number `since` of `run`."""
        return messages.Missed(since=since, events=self._recent[room.id].since(run, since, key))

    def greet(self, room: AnyRoom, client: Client) -> None:
        """Give a client the full state to start from."""
        hello = msgspec.structs.replace(
            room.hello(self._clock(), self._limits, client.stream),
            run=self._recent[room.id].run,
            key=client.key,
        )
        client.post(Frame.event(messages.encode_event(hello)))
        if isinstance(room, ArenaRoom):
            # Balls at rest are there too, and nothing moves that would have them shown.
            client.show(Frame.picture(room.frame(first=True)))
        elif client.stream == messages.SEGMENTS:
            room.watch_segments(True)
            client.show(Frame.picture(room.all_segments()))

    def announce(
        self, room: AnyRoom, seq: int, giver: Giver, event: messages.Event
    ) -> messages.Event:
        """Tell everyone what came of an input; its note goes to who gave it alone."""
        own = event
        noted = isinstance(event, messages.Accepted | messages.Placed)
        self._recent[room.id].add(seq, event, giver.key if noted else "", giver.ref)
        if isinstance(event, messages.Accepted | messages.Placed):
            own = msgspec.structs.replace(event, ref=giver.ref)
        if giver.client is not None:
            self._hub.tell(room.id, giver.client, messages.encode_event(own))
        if self._hub.count(room.id) > (giver.client is not None):
            self._hub.announce(room.id, messages.encode_event(event), skip=giver.client)
        return own

    def tell(
        self, room: AnyRoom, events: list[messages.Event], *, with_picture: bool = False
    ) -> None:
        """Send events, and the picture of this moment, to all who watch."""
        for seq, event in enumerate(events, room.seq - len(events) + 1):
            self._recent[room.id].add(seq, event)
        if self._hub.count(room.id, messages.SNAPSHOTS) and (events or with_picture):
            told = messages.encode_events(events) if events else None
            picture = room.frame() if with_picture else None
            self._hub.publish(room.id, messages.SNAPSHOTS, told, picture)
        if not isinstance(room, ArenaRoom):
            self._tell_segments(room, events, with_picture)

    def _tell_segments(self, room: Room, events: list[messages.Event], with_pieces: bool) -> None:
        """Send what clients that draw the paths themselves need: no contacts, and new pieces."""
        watched = self._hub.count(room.id, messages.SEGMENTS) > 0
        room.watch_segments(watched)
        if not watched:
            return
        pieces = room.segments() if with_pieces else None
        told = [event for event in events if not isinstance(event, messages.Contact)]
        if told or pieces is not None:
            text = messages.encode_events(told) if told else None
            self._hub.publish(room.id, messages.SEGMENTS, text, pieces)

    def watch(self, room: ArenaRoom, client: int, wanted: bool) -> None:
        """Send a client the room's diagnostics from now on, or no more."""
        if not wanted:
            self.unwatch(room.id, client)
            return
        self._curious.setdefault(room.id, set()).add(client)
        self._hub.tell(room.id, client, messages.encode_event(room.diagnostics()))

    def unwatch(self, room_id: str, client: int) -> None:
        """Send a client no diagnostics any more, if it had them sent."""
        watchers = self._curious.get(room_id, set())
        watchers.discard(client)
        if not watchers:
            self._curious.pop(room_id, None)

    def diagnose(self, room: AnyRoom, before: int) -> None:
        """Tell the diagnostics to those who watch them: a few times a second, and at the end.

        before: the tick that the room was at when this was last called.
        """
        watchers = self._curious.get(room.id)
        if not watchers or not isinstance(room, ArenaRoom):
            return
        if room.world.tick // self._every == before // self._every and room.awake:
            return
        told = messages.encode_event(room.diagnostics())
        for client in watchers:
            self._hub.tell(room.id, client, told)
