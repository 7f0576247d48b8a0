"""Sends a room's clients the full state, then events, snapshots and diagnostics."""

from collections import deque
from collections.abc import Callable, Container
from dataclasses import dataclass
from typing import Final, cast

import msgspec

from plinko.app.live.broadcast.hub import Client, Hub
from plinko.app.live.broadcast.presence import Presence
from plinko.app.live.orders import Orders
from plinko.app.protocol import messages
from plinko.app.protocol.seeds import SeedStream, SparseStream
from plinko.app.protocol.visitors import Appearance
from plinko.app.protocol.wire import WireMessage
from plinko.app.rooms.keys import IdempotencyKey
from plinko.app.rooms.room import Room
from plinko.app.settings import TICK_RATE, Settings
from plinko.engine import Board

KEPT: Final = 256  # events, without contacts: a late bounce interests no client

_EVERY: Final = TICK_RATE // 5  # ticks between two diagnostics, for clients that asked for them


@dataclass(frozen=True, kw_only=True)
class Player:
    """The sender of a request to a room.

    client: the connection. Only it receives the `ref`.
    key: identifies the connection after a reconnect.
    ref: the client's own reference for the request, which the answer repeats.
    idempotency_key: identifies a repeated drop.
    """

    client: int | None = None
    key: str = ""
    ref: object = None  # any JSON value
    idempotency_key: IdempotencyKey | None = None


NOBODY: Final = Player()


@dataclass(frozen=True)
class AudienceContext:
    """What the audiences of all rooms share. orders: those of the operator, if there are any."""

    hub: Hub
    presence: Presence
    clock: Callable[[], float]
    orders: Orders | None
    limits: messages.Limits

    @classmethod
    def of(
        cls,
        hub: Hub,
        settings: Settings,
        clock: Callable[[], float],
        orders: Orders | None = None,
        presence: Presence | None = None,
    ) -> "AudienceContext":
        limits = messages.Limits(settings.max_balls, settings.drop_rate, messages.MESSAGE_BYTES)
        return cls(hub, presence or Presence(clock), clock, orders, limits)


class Audience:
    """The clients of one room. It remembers recent events, for clients that reconnect.

    `run` identifies the room run for clients.
    """

    def __init__(self, context: AudienceContext, room: Room, run: str) -> None:
        self._context = context
        self._hub = context.hub
        self._diagnosed: set[int] = set()  # clients that receive diagnostics
        self._sparse: dict[str, SparseStream] = {}  # `paths` and `seeds`, while clients have them
        self._begin(room, run)
        self._told = self._orders

    def _begin(self, room: Room, run: str) -> None:
        self.room = room
        self._recent = Recent(run, room.seq)
        self._tick = room.world.tick  # of the last broadcast

    def begin(self, room: Room, run: str) -> None:
        """Continue with another run of the room; every client gets a new hello."""
        self.release()
        self._sparse.clear()
        self._begin(room, run)
        for client in self._hub.clients(room.id):
            self.greet(client)

    def release(self) -> None:
        """Send landings that wait in sparse streams, before a hello that already counts them."""
        for stream, sparse in self._sparse.items():
            self._send(stream, sparse.release())

    def missed(self, client: Client, run: str, since: int, key: str) -> messages.Missed:
        """The events after number `since` of `run`, up to the client's latest hello.

        key: the client's key in the connection that it lost.
        """
        events = self._recent.since(run, since, key, client.greeted)
        return messages.Missed(since=since, until=client.greeted, events=events)

    # Clients.

    def enter(self, client: Client) -> None:
        """Let a client watch: it gets the full state, then all events. Raises RoomFullError."""
        self.release()
        self._hub.join(self.room.id, client)
        self.greet(client)

    def leave(self, client: Client) -> None:
        self._hub.leave(self.room.id, client)
        self._diagnosed.discard(client.id)
        self._context.presence.leave(self.room.id, client.id)

    def greet(self, client: Client) -> None:
        room = self.room
        hello = msgspec.structs.replace(
            room.hello(self._context.clock(), self._context.limits, client.stream),
            run=self._recent.run,
            key=client.key,
        )
        client.greeted = room.seq
        client.post(WireMessage.of_text(messages.encode_event(hello)))
        first = room.first_message(client.stream)
        if first is not None:
            client.show(WireMessage.of_bytes(first))
        halted, notice = self._orders
        for event in (halted,) * halted.halted + (notice,) * (notice.text is not None):
            client.post(WireMessage.of_text(messages.encode_event(event)))

    def appear(self, client: Client, appearance: Appearance) -> messages.Presence:
        """Make a client a visitor; returns its answer. The other visitors are informed soon."""
        return self._context.presence.appear(self.room.id, client, appearance)

    @property
    def _orders(self) -> tuple[messages.Halted, messages.Notice]:
        orders = self._context.orders
        halted = orders is not None and orders.holds(self.room.id)
        text = None if orders is None else orders.notice
        return messages.Halted(halted=halted), messages.Notice(text=text)

    def tell_orders(self) -> None:
        """Tell all clients whether the room is halted, and what the operator announces."""
        before, self._told = self._told, self._orders
        for event, known in zip(self._told, before, strict=True):
            if event != known:
                self.notify(event)

    def notify(self, event: messages.Event, only: Container[int] | None = None) -> None:
        """Send clients, perhaps `only` these, an event that is not one of the numbered events."""
        message = WireMessage.of_text(messages.encode_event(event))
        for client in self._hub.clients(self.room.id):
            if only is None or client.id in only:
                client.post(message)

    # Events and snapshots.

    def announce(self, seq: int, player: Player, event: messages.Event) -> messages.Event:
        """Send all clients event number `seq`; only the player's own copy has the `ref`.

        Returns that copy.
        """
        room_id = self.room.id
        event = self._context.presence.signed(room_id, player.client, event)
        noted = messages.has_ref(event)
        self._recent.add(seq, event, player.key if noted else "", player.ref)
        own = msgspec.structs.replace(event, ref=player.ref) if noted else event
        for stream in messages.STREAMS:
            if self._hub.count(room_id, stream):
                encode = self._encoder(stream)
                self._hub.announce(room_id, stream, encode(event), player.client, encode(own))
        if isinstance(event, messages.Accepted) and self._hub.count(room_id, messages.PATHS):
            self._hub.post(room_id, messages.PATHS, self.room.current_path(event.ball))
        return own

    def _encoder(self, stream: str) -> Callable[[messages.Event], bytes]:
        """The encoder of this stream; landings that wait in a sparse stream precede the event."""
        if stream == messages.SNAPSHOTS:
            return messages.encode_event
        sparse = self._sparse_stream(stream)
        held = sparse.release()
        return lambda event: messages.encode_events([*held, sparse.form(event)])

    def broadcast(self, events: list[messages.Event], *, with_snapshot: bool = False) -> None:
        """Send all clients the latest events of the room, and a snapshot if wanted."""
        room = self.room
        for seq, event in enumerate(events, room.seq - len(events) + 1):
            self._recent.add(seq, event)
        if self._hub.count(room.id, messages.SNAPSHOTS) and (events or with_snapshot):
            text = messages.encode_events(events) if events else None
            snapshot = room.snapshot() if with_snapshot else None
            self._hub.publish(room.id, messages.SNAPSHOTS, text, snapshot)
        if self._hub.count(room.id, messages.PATHS) and (parts := room.due_paths(self._tick)):
            self._hub.post(room.id, messages.PATHS, parts)
        self._tick = room.world.tick
        for stream in (messages.PATHS, messages.SEEDS):
            self._broadcast_sparse(stream, events)

    def _broadcast_sparse(self, stream: str, events: list[messages.Event]) -> None:
        """Send clients that know or compute the paths the events that are due."""
        room = self.room
        if not self._hub.count(room.id, stream):
            self._sparse.pop(stream, None)
            return
        sparse = self._sparse_stream(stream)
        sparse.hold(events, room.world.tick)
        self._send(stream, sparse.take(room.world.tick, room.seq, awake=room.awake))

    def _sparse_stream(self, stream: str) -> SparseStream:
        """One of the sparse streams, which only a room of independent balls has."""
        if stream not in self._sparse:
            rate, tick = self.room.tick_rate, self.room.world.tick
            if stream == messages.SEEDS:
                zone = cast(Board, self.room.ground).drop
                self._sparse[stream] = SeedStream(rate, tick, zone)
            else:
                self._sparse[stream] = SparseStream(rate, tick)
        return self._sparse[stream]

    def _send(self, stream: str, events: list[messages.Event]) -> None:
        if events:
            self._hub.publish(self.room.id, stream, messages.encode_events(events), None)

    # Diagnostics.

    def watch_diagnostics(self, client: int, wanted: bool) -> None:
        """Start or stop sending a client the room's diagnostics.

        Raises InvalidValueError if the room has none.
        """
        self.room.check_changeable()
        if not wanted:
            self._diagnosed.discard(client)
            return
        self._diagnosed.add(client)
        self.notify(self.room.diagnostics(), {client})

    def diagnose(self, before: int) -> None:
        """Send the diagnostics, a few times a second and when the room falls asleep.

        before: the room's tick at the previous call.
        """
        room = self.room
        if not self._diagnosed:
            return
        if room.world.tick // _EVERY == before // _EVERY and room.awake:
            return
        self.notify(room.diagnostics(), self._diagnosed)


class Recent:
    """The last events of one room run by number, without contacts; `run` is its id.

    The events up to number `seq` are missing.
    """

    def __init__(self, run: str, seq: int = 0) -> None:
        self.run = run
        self._events: deque[tuple[int, messages.Event, str, object]] = deque(maxlen=KEPT)
        self._lost = seq  # number of the latest event that the buffer no longer has

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
