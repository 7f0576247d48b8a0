"""What those who watch a room are sent: the state to start from, events, snapshots, diagnostics."""

from collections.abc import Callable, Iterable
from typing import cast

import msgspec

from app.live.broadcast.hub import Client, Hub
from app.live.broadcast.presence import Presence
from app.live.broadcast.replay_buffer import Recent
from app.protocol import messages
from app.protocol.seeds import SeedStream
from app.protocol.wire import WireMessage
from app.rooms.pending import Requester
from app.rooms.room import Room
from app.settings import Settings
from engine import Board

_DIAGNOSED = 5  # times a second, for those who watch a room's diagnostics


class Broadcaster:
    """Sends by the hub what comes out of rooms; remembers it for who lost their connection."""

    def __init__(self, hub: Hub, settings: Settings, clock: Callable[[], float]) -> None:
        self._hub = hub
        self._clock = clock
        self.presence = Presence(clock)
        self._every = max(1, settings.tick_rate // _DIAGNOSED)  # ticks
        self._limits = messages.Limits(settings.max_balls, settings.drop_rate, settings.max_message)
        self.halted: Callable[[str], bool] = lambda _: False  # for whoever decides it to set
        self._recent: dict[str, Recent] = {}
        self._seeds: dict[str, SeedStream] = {}  # of the rooms that are watched so
        self._diagnosed: dict[str, set[int]] = {}  # clients that watch a room's diagnostics

    def begin(self, room: Room, run: str) -> None:
        """Begin to remember what is announced in this life of a room, whose name is `run`."""
        self._recent[room.id] = Recent(run)
        self._recent[room.id].begin(room.seq)
        self.release(room.id)
        self._seeds.pop(room.id, None)

    def forget(self, room_id: str) -> None:
        """A room is not in memory any more; what was held back of it is told."""
        self.release(room_id)
        self._recent.pop(room_id, None)
        self._seeds.pop(room_id, None)

    def release(self, room_id: str) -> None:
        """Tell what is held back, before somebody is greeted: a hello knows it already."""
        if room_id in self._seeds:
            self._tell_seeds(room_id, self._seeds[room_id].release())

    def missed(self, room: Room, client: Client, run: str, since: int, key: str) -> messages.Missed:
        """What the client missed after event number `since` of `run`, where its key was `key`.

        Up to its hello: what came after that it has heard.
        """
        events = self._recent[room.id].since(run, since, key, client.greeted)
        return messages.Missed(since=since, until=client.greeted, events=events)

    def greet(self, room: Room, client: Client) -> None:
        """Give a client the full state to start from."""
        hello = msgspec.structs.replace(
            room.hello(self._clock(), self._limits, client.stream),
            run=self._recent[room.id].run,
            key=client.key,
        )
        client.greeted = room.seq
        client.post(WireMessage.of_text(messages.encode_event(hello)))
        first = room.first_message(client.stream)
        if first is not None:
            client.show(WireMessage.of_bytes(first))
        if self.halted(room.id):
            client.post(WireMessage.of_text(messages.encode_event(messages.Halted(halted=True))))

    def greet_all(self, room: Room) -> None:
        """Everyone who watches a room starts over."""
        for client in self._hub.clients(room.id):
            self.greet(room, client)

    def tell_halts(self, rooms: Iterable[Room]) -> None:
        """Tell those who watch these rooms whether they take anything new."""
        for room in rooms:
            event = messages.encode_event(messages.Halted(halted=self.halted(room.id)))
            for client in self._hub.clients(room.id):
                self._hub.notify(room.id, client.id, event)

    def announce(
        self, room: Room, seq: int, requester: Requester, event: messages.Event
    ) -> messages.Event:
        """Send everyone what came of an input; its note goes to the requester alone."""
        event = self.presence.signed(room.id, requester.client, event)
        noted = messages.has_ref(event)
        self._recent[room.id].add(seq, event, requester.key if noted else "", requester.ref)
        own = msgspec.structs.replace(event, ref=requester.ref) if noted else event
        for stream in messages.STREAMS:
            if self._hub.count(room.id, stream):
                encode = self._encoder(room, stream)
                self._hub.announce(room.id, stream, encode(event), requester.client, encode(own))
        return own

    def _encoder(self, room: Room, stream: str) -> Callable[[messages.Event], bytes]:
        """How an event becomes a message of this stream, with what is told before it."""
        if stream != messages.SEEDS:
            return messages.encode_event
        seeds = self._seed_stream(room)
        held = seeds.release()
        return lambda event: messages.encode_events([*held, seeds.brief(event)])

    def broadcast(
        self, room: Room, events: list[messages.Event], *, with_snapshot: bool = False
    ) -> None:
        """Send events, and the snapshot of this moment, to all who watch."""
        for seq, event in enumerate(events, room.seq - len(events) + 1):
            self._recent[room.id].add(seq, event)
        if self._hub.count(room.id, messages.SNAPSHOTS) and (events or with_snapshot):
            text = messages.encode_events(events) if events else None
            snapshot = room.snapshot() if with_snapshot else None
            self._hub.publish(room.id, messages.SNAPSHOTS, text, snapshot)
        self._broadcast_segments(room, events, with_snapshot)
        self._broadcast_seeds(room, events)

    def _broadcast_segments(
        self, room: Room, events: list[messages.Event], with_segments: bool
    ) -> None:
        """Send what clients that draw the paths themselves need: no contacts, and new segments."""
        watched = self._hub.count(room.id, messages.SEGMENTS) > 0
        room.watch_segments(watched)
        if not watched:
            return
        segments = room.segments() if with_segments else None
        heard = [event for event in events if not isinstance(event, messages.Contact)]
        if heard or segments is not None:
            text = messages.encode_events(heard) if heard else None
            self._hub.publish(room.id, messages.SEGMENTS, text, segments)

    def _broadcast_seeds(self, room: Room, events: list[messages.Event]) -> None:
        """Send what clients need that compute the paths themselves."""
        if not self._hub.count(room.id, messages.SEEDS):
            self._seeds.pop(room.id, None)
            return
        seeds = self._seed_stream(room)
        seeds.hold(events, room.world.tick)
        self._tell_seeds(room.id, seeds.take(room.world.tick, room.seq, awake=room.awake))

    def _seed_stream(self, room: Room) -> SeedStream:
        """What those are told who watch a room by seeds; it must be one of independent balls."""
        if room.id not in self._seeds:
            zone = cast(Board, room.ground).drop
            self._seeds[room.id] = SeedStream(room.tick_rate, room.world.tick, zone)
        return self._seeds[room.id]

    def _tell_seeds(self, room_id: str, events: list[messages.Event]) -> None:
        if events:
            self._hub.publish(room_id, messages.SEEDS, messages.encode_events(events), None)

    def watch_diagnostics(self, room: Room, client: int, wanted: bool) -> None:
        """Send a client the room's diagnostics from now on, or no more.

        Raises InvalidValueError for a room that has none.
        """
        room.check_changeable()
        if not wanted:
            self.unwatch(room.id, client)
            return
        self._diagnosed.setdefault(room.id, set()).add(client)
        self._hub.notify(room.id, client, messages.encode_event(room.diagnostics()))

    def unwatch(self, room_id: str, client: int) -> None:
        """Send a client no diagnostics any more, if it had them sent."""
        watchers = self._diagnosed.get(room_id, set())
        watchers.discard(client)
        if not watchers:
            self._diagnosed.pop(room_id, None)

    def diagnose(self, room: Room, before: int) -> None:
        """Send the diagnostics to those who watch them: a few times a second, and at the end.

        before: the tick that the room was at when this was last called.
        """
        watchers = self._diagnosed.get(room.id)
        if not watchers:
            return
        if room.world.tick // self._every == before // self._every and room.awake:
            return
        event = messages.encode_event(room.diagnostics())
        for client in watchers:
            self._hub.notify(room.id, client, event)
