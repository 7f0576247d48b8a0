"""What those who watch a room are sent: the state to start from, events, snapshots, diagnostics."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, cast

import msgspec

from app.live.broadcast.hub import Client, Hub
from app.live.broadcast.presence import Presence
from app.live.broadcast.replay_buffer import Recent
from app.protocol import messages
from app.protocol.seeds import SeedStream
from app.protocol.wire import WireMessage
from app.rooms.room import Room
from app.settings import Settings
from engine import Board

_DIAGNOSED: Final = 5  # times a second, for those who watch a room's diagnostics


@dataclass(frozen=True, kw_only=True)
class Player:
    """Who asks something of a room, and by what note `ref` they know it.

    client: the connection, which alone is told the note; key: names it if it comes back; again:
    names the drop if it is asked for again, in this room run.
    """

    client: int | None = None
    key: str = ""
    ref: object = None  # JSON, as it came
    again: str | None = None


NOBODY: Final = Player()


@dataclass(frozen=True)
class Means:
    """What the audiences of all rooms have in common. `halted` says of a room whether it is."""

    hub: Hub
    presence: Presence
    clock: Callable[[], float]
    halted: Callable[[str], bool]
    every: int  # ticks between two diagnostics
    limits: messages.Limits

    @classmethod
    def of(
        cls,
        hub: Hub,
        settings: Settings,
        clock: Callable[[], float],
        halted: Callable[[str], bool] = lambda _: False,
        presence: Presence | None = None,
    ) -> "Means":
        """With the limits that the settings state."""
        every = max(1, settings.tick_rate // _DIAGNOSED)
        limits = messages.Limits(settings.max_balls, settings.drop_rate, messages.MESSAGE_BYTES)
        return cls(hub, presence or Presence(clock), clock, halted, every, limits)


class Audience:
    """The clients that watch one room. It remembers what it told, for those who lost their line.

    `run` names the room's present life.
    """

    def __init__(self, means: Means, room: Room, run: str) -> None:
        self._means = means
        self._hub = means.hub
        self._diagnosed: set[int] = set()  # clients that watch the diagnostics
        self._seeds: SeedStream | None = None  # while somebody watches by seeds
        self._begin(room, run)

    def _begin(self, room: Room, run: str) -> None:
        self.room = room
        self._recent = Recent(run)
        self._recent.begin(room.seq)

    def begin(self, room: Room, run: str) -> None:
        """Go on with another life of the room, in which everyone who watches starts over."""
        self.release()
        self._seeds = None
        self._begin(room, run)
        for client in self._hub.clients(room.id):
            self.greet(client)

    def release(self) -> None:
        """Tell what is held back, before somebody is greeted: a hello knows it already."""
        if self._seeds is not None:
            self._tell_seeds(self._seeds.release())

    def missed(self, client: Client, run: str, since: int, key: str) -> messages.Missed:
        """What the client missed after event number `since` of `run`, where its key was `key`.

        Up to its hello: what came after that it has heard.
        """
        events = self._recent.since(run, since, key, client.greeted)
        return messages.Missed(since=since, until=client.greeted, events=events)

    # Who watches.

    def enter(self, client: Client) -> None:
        """Let a client watch: the full state first, then all that happens. Raises RoomFullError."""
        self.release()
        self._hub.join(self.room.id, client)
        self.greet(client)

    def leave(self, client: Client) -> None:
        self._hub.leave(self.room.id, client)
        self._diagnosed.discard(client.id)
        self._means.presence.leave(self.room.id, client.id)

    def greet(self, client: Client) -> None:
        room = self.room
        hello = msgspec.structs.replace(
            room.hello(self._means.clock(), self._means.limits, client.stream),
            run=self._recent.run,
            key=client.key,
        )
        client.greeted = room.seq
        client.post(WireMessage.of_text(messages.encode_event(hello)))
        first = room.first_message(client.stream)
        if first is not None:
            client.show(WireMessage.of_bytes(first))
        if self._means.halted(room.id):
            client.post(WireMessage.of_text(messages.encode_event(messages.Halted(halted=True))))

    def appear(self, client: Client, name: str | None, colour: str | None) -> messages.Presence:
        """Show a client to the others; returns what to tell it now. The others hear it soon."""
        return self._means.presence.appear(self.room.id, client, name, colour)

    def tell_halt(self) -> None:
        """Tell everyone whether the room takes anything new."""
        self.notify(messages.Halted(halted=self._means.halted(self.room.id)))

    def notify(self, event: messages.Event) -> None:
        """Tell everyone what is no event of the room."""
        text = messages.encode_event(event)
        for client in self._hub.clients(self.room.id):
            self._hub.notify(self.room.id, client.id, text)

    # What is told.

    def announce(self, seq: int, player: Player, event: messages.Event) -> messages.Event:
        """Send everyone what came of an input; the note goes to who asked for it alone."""
        room_id = self.room.id
        event = self._means.presence.signed(room_id, player.client, event)
        noted = messages.has_ref(event)
        self._recent.add(seq, event, player.key if noted else "", player.ref)
        own = msgspec.structs.replace(event, ref=player.ref) if noted else event
        for stream in messages.STREAMS:
            if self._hub.count(room_id, stream):
                encode = self._encoder(stream)
                self._hub.announce(room_id, stream, encode(event), player.client, encode(own))
        return own

    def _encoder(self, stream: str) -> Callable[[messages.Event], bytes]:
        """What makes a message of this stream from an event; held landings go before it."""
        if stream != messages.SEEDS:
            return messages.encode_event
        seeds = self._seed_stream()
        held = seeds.release()
        return lambda event: messages.encode_events([*held, seeds.brief(event)])

    def broadcast(self, events: list[messages.Event], *, with_snapshot: bool = False) -> None:
        """Send events, and the snapshot of this moment, to all who watch."""
        room = self.room
        for seq, event in enumerate(events, room.seq - len(events) + 1):
            self._recent.add(seq, event)
        if self._hub.count(room.id, messages.SNAPSHOTS) and (events or with_snapshot):
            text = messages.encode_events(events) if events else None
            snapshot = room.snapshot() if with_snapshot else None
            self._hub.publish(room.id, messages.SNAPSHOTS, text, snapshot)
        self._broadcast_segments(events, with_snapshot)
        self._broadcast_seeds(events)

    def _broadcast_segments(self, events: list[messages.Event], with_segments: bool) -> None:
        """Send what clients that draw the paths themselves need: no contacts, and new segments."""
        room = self.room
        watched = self._hub.count(room.id, messages.SEGMENTS) > 0
        room.watch_segments(watched)
        if not watched:
            return
        segments = room.segments() if with_segments else None
        heard = [event for event in events if not isinstance(event, messages.Contact)]
        if heard or segments is not None:
            text = messages.encode_events(heard) if heard else None
            self._hub.publish(room.id, messages.SEGMENTS, text, segments)

    def _broadcast_seeds(self, events: list[messages.Event]) -> None:
        """Send what clients need that compute the paths themselves."""
        room = self.room
        if not self._hub.count(room.id, messages.SEEDS):
            self._seeds = None
            return
        seeds = self._seed_stream()
        seeds.hold(events, room.world.tick)
        self._tell_seeds(seeds.take(room.world.tick, room.seq, awake=room.awake))

    def _seed_stream(self) -> SeedStream:
        """The stream for clients that watch by seeds. The room must be one of independent balls."""
        if self._seeds is None:
            zone = cast(Board, self.room.ground).drop
            self._seeds = SeedStream(self.room.tick_rate, self.room.world.tick, zone)
        return self._seeds

    def _tell_seeds(self, events: list[messages.Event]) -> None:
        if events:
            text = messages.encode_events(events)
            self._hub.publish(self.room.id, messages.SEEDS, text, None)

    # Diagnostics.

    def watch_diagnostics(self, client: int, wanted: bool) -> None:
        """Send a client the room's diagnostics from now on, or no more.

        Raises InvalidValueError for a room that has none.
        """
        self.room.check_changeable()
        if not wanted:
            self._diagnosed.discard(client)
            return
        self._diagnosed.add(client)
        self._hub.notify(self.room.id, client, messages.encode_event(self.room.diagnostics()))

    def diagnose(self, before: int) -> None:
        """Send the diagnostics to those who watch them: a few times a second, and at the end.

        before: the tick that the room was at when this was last called.
        """
        room, every = self.room, self._means.every
        if not self._diagnosed:
            return
        if room.world.tick // every == before // every and room.awake:
            return
        event = messages.encode_event(room.diagnostics())
        for client in self._diagnosed:
            self._hub.notify(room.id, client, event)
