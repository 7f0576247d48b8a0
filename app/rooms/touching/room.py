"""A room whose balls touch each other: every change to it is an input at a tick.

Replaying the inputs at their ticks therefore gives the same room, to the last bit: after a crash,
and when somebody verifies its log.

An input is planned for a tick, confirmed once it is durable, and carried out at that tick. If the
tick comes before the input is confirmed or refused, the room waits (`held`): the tick at which an
input enters never depends on how long the ledger took.
"""

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Final

import msgspec
import numpy as np
import numpy.typing as npt

from plinko.app.errors import InvalidValueError
from plinko.app.protocol import messages
from plinko.app.protocol import touching_messages as wire
from plinko.app.rooms.pending import DropCommand, Entered, PendingInput
from plinko.app.rooms.room import QUIET, Basis, Ground, Room
from plinko.app.rooms.touching import values
from plinko.app.rooms.touching.checks import BALL_NAMES, InputCheck, no_such_ball, spot_of
from plinko.app.rooms.touching.inputs import ChangeFormat, TouchingCommand
from plinko.app.rooms.touching.scene import Scene
from plinko.app.rooms.touching.table import Fall, Table
from plinko.app.rooms.touching.world import Box, NextTick, TouchingWorld
from plinko.engine import Board
from plinko.engine.constants import KIND_BALL, KIND_PEG, KIND_WALL
from plinko.engine.errors import RecordError
from plinko.engine.json_text import JsonObject
from plinko.engine.multibody.events import ArenaEvent, Landed, Left, Touch

INTERACTING: Final = "interacting"
SCENE: Final = "scene"  # the ledger's mode of a room without a board

DEAR: Final = 400
"""Balls times substeps in a tick. From here on another thread computes the tick: it takes 0.2 ms,
and several times that in a heap, while handing it over and taking it back costs 0.1 ms."""

_MOST_CONTACTS: Final = 24
"""Contacts sent per tick, the hardest ones: more would only be noise, at a cost to each client."""

_KINDS: Final = {"peg": KIND_PEG, "wall": KIND_WALL, "ball": KIND_BALL}

_VELOCITY_SCALE: Final = 1.0 / 256.0  # m/s; reaches to 128 m/s


class _Checkpoint(msgspec.Struct, frozen=True):
    """The state of a room between two ticks."""

    world: bytes
    scene: dict[str, object] | None
    seq: int
    taken: int
    drops: int
    unsettled: int
    histogram: list[int]
    flights: list[tuple[messages.BallStart, float]]
    paused: bool
    steps: int
    settings: dict[str, float]


class TouchingRoom(Room):
    """A scene, or a board with balls that knock each other."""

    kind = INTERACTING
    solver = "stepped"
    format = ChangeFormat()

    world: TouchingWorld

    def __init__(self, room_id: str, origin: Ground, *, tick_rate: int, max_balls: int) -> None:
        mode = SCENE if isinstance(origin, Scene) else INTERACTING
        self.paused = False
        self.velocity_scale = _VELOCITY_SCALE
        self._input_count = 0
        self._steps = 0  # ticks still to run while the clock is stopped
        self._next: NextTick | None = None
        self.planned: deque[PendingInput[TouchingCommand]] = deque()
        super().__init__(room_id, origin, mode, tick_rate=tick_rate, max_balls=max_balls)

    def _begin_on(self, ground: Ground, tick: int = 0) -> None:
        super()._begin_on(ground)
        self.table = Table(ground, self.tick_rate, tick)
        self.world = self.table.world
        self.extent = self.world.extent
        self._next = None

    @property
    def input_count(self) -> int:
        return self._input_count

    @property
    def awake(self) -> bool:
        return bool(self.planned) or (self._steps > 0 if self.paused else self.world.awake)

    @property
    def held(self) -> bool:
        """Whether the next tick must wait until a planned input has entered or was refused."""
        return bool(self.planned) and self.planned[0].tick <= self.world.tick

    @property
    def _runs(self) -> bool:
        return self.world.awake and not self.paused

    @property
    def balls(self) -> list[messages.BallStart]:
        return [fall.start for fall in self.table.falls.values()]

    @property
    def is_scene(self) -> bool:
        """Whether it was opened with a scene: then no player waits for a drop to land."""
        return isinstance(self.origin, Scene)

    @property
    def box(self) -> Box | None:
        if isinstance(self.ground, Scene):
            return Box(self.world.place, self.ground.radius)
        return None

    def basis_after_reset(self, board: Board | None = None) -> Basis:
        """What a reset starts from; raises InvalidValueError for a board if it has a scene."""
        if board is not None and isinstance(self.origin, Scene):
            raise InvalidValueError(
                f"room {self.id!r} is a scene without a board: leave board out", field="board"
            )
        return super().basis_after_reset(board)

    # Inputs.

    def plan_drop(self, command: DropCommand, lead: int = 0) -> PendingInput[TouchingCommand]:
        """Plan a drop `lead` ticks from now, or for the current tick if nothing moves.

        Raises BallLimitError when the room is full, InvalidValueError if it has no board or the
        drop has a stake or a tag, and the engine's errors for a bad start; an error leaves the room
        unchanged.
        """
        checked = TouchingCommand(self._check().drop(command), command.who)
        return self._plan(checked, lead)

    def plan_change(self, change: wire.Change, lead: int = 0) -> PendingInput[TouchingCommand]:
        """Plan a change as `plan_drop` plans a drop.

        Raises InvalidValueError for an invalid change, MissingBallError, and BallLimitError when
        the room is full.
        """
        return self._plan(TouchingCommand(self._check().change(change)), lead)

    def _plan(self, command: TouchingCommand, lead: int) -> PendingInput[TouchingCommand]:
        tick = self.world.tick + lead if self._runs else self.world.tick
        if self.planned:
            tick = max(tick, self.planned[-1].tick)
        pending = PendingInput(tick, command)
        self.planned.append(pending)
        return pending

    def refuse(self, pending: PendingInput[TouchingCommand]) -> None:
        """Remove a planned input that the ledger has refused."""
        self.planned.remove(pending)

    def enter(self) -> list[Entered]:
        """Carry out the confirmed inputs whose tick has come."""
        entered: list[Entered] = []
        while self.planned and self.planned[0].durable and self.held:
            # If this raises, the input stays planned, so that its client still gets an answer.
            entered.append(self._carry_out(self.planned[0]))
            self.planned.popleft()
        return entered

    def drop(self, command: DropCommand) -> messages.Accepted:
        pending = self.plan_drop(command)
        pending.durable = True
        (accepted,) = self.enter()[-1].events
        assert isinstance(accepted, messages.Accepted)
        return accepted

    def check_changeable(self) -> None:
        """Raise nothing: clients may move and change touching balls."""

    def _check(self) -> InputCheck:
        spots = (spot_of(each.command.input, self.ground) for each in self.planned)
        return InputCheck(
            room_id=self.id,
            ground=self.ground,
            world=self.world,
            tick_rate=self.tick_rate,
            max_balls=self.max_balls,
            coming=tuple(spot for spot in spots if spot is not None),
            made_of=self.table.made_of,
        )

    def replay(self, entry: JsonObject) -> None:
        command = TouchingCommand(self.format.input(entry))
        self._carry_out(PendingInput(self.world.tick, command))

    def _carry_out(self, pending: PendingInput[TouchingCommand]) -> Entered:
        if pending.number not in (None, self.input_count) or pending.tick != self.world.tick:
            raise RuntimeError(
                f"{pending} came as input {self.input_count} at tick {self.world.tick}"
            )
        pending.number = self.input_count
        self._input_count += 1
        self._next = None
        self.touched = True
        asked = pending.command.input
        ball = getattr(asked, "ball", None)
        if ball is not None and not self.world.has(ball):
            return Entered(pending, [], failed=no_such_ball(ball))
        events = self.table.carry_out(asked)
        match asked:
            case wire.SettingsMessage():
                events.append(self._settings_event())
            case wire.PauseMessage():
                self.paused, self._steps = asked.paused, 0
                events.append(self._settings_event())
            case wire.StepMessage():
                self._steps += self.paused
            case wire.ResetMessage(scene=scene):
                ground = Scene(scene) if isinstance(scene, dict) else self.ground
                self._begin_on(ground, self.world.tick)
        self.drops += sum(isinstance(event, messages.Accepted) for event in events)
        self.seq += len(events)
        return Entered(pending, events, isinstance(asked, wire.ResetMessage))

    def _settings_event(self) -> messages.RoomSettings:
        return messages.RoomSettings(
            tick=self.world.tick, settings=self.table.settings(), paused=self.paused
        )

    # Time.

    @property
    def steps_aside(self) -> bool:
        """Whether the next tick takes so long that another thread should compute it."""
        settings = self.world.arena.settings
        return self.world.count * settings.substeps >= DEAR * settings.dt * self.tick_rate

    @property
    def ready(self) -> bool:
        """Whether `step` will be quick, because the costly part of the next tick is done."""
        return not self.steps_aside or (self._next is not None and self._next.done)

    def begin_step(self) -> Callable[[], None] | None:
        """A function for another thread that computes the next tick; None if there is no need.

        The function shares no data with any other code. When it has returned, the room is ready,
        unless an input was carried out meanwhile: then another step has to begin.
        """
        if self._next is not None or self.held or not self.awake or not self.steps_aside:
            return None
        self._next = NextTick(self.world)
        return self._next.compute

    def step(self, *, watched: bool) -> list[messages.Event]:
        begun, self._next = self._next, None
        if begun is not None and begun.done:
            self.world.become(begun.take())
        else:
            self.world.step()
        if self._steps:
            self._steps -= 1
        events = self._happened(watched)
        events += self._settle()
        self.seq += len(events)
        if watched:
            self._note_bounces()
        return events

    def advance(self, tick: int, *, watched: bool = False) -> list[messages.Event]:
        events: list[messages.Event] = []
        while self.world.tick < tick:
            events += self.step(watched=watched)
        return events

    def _happened(self, watched: bool) -> list[messages.Event]:
        arena = self.world.arena
        happened: Sequence[ArenaEvent]
        if watched and isinstance(self.ground, Board):
            happened = arena.take_events()
        else:
            happened = arena.take_landings()
        events: list[messages.Event] = []
        touches: list[Touch] = []
        for one in happened:
            if isinstance(one, Landed):
                events += self._land(one)
            elif isinstance(one, Left):
                self.table.falls.pop(one.ball, None)
                events.append(messages.Removed(tick=self.world.tick, balls=[one.ball]))
            else:
                touches.append(one)
        return [*_contacts(touches, self.table.falls, self.world.tick), *events]

    def _land(self, landed: Landed) -> list[messages.Event]:
        fall = self.table.falls.pop(landed.ball, None)
        if fall is None:  # an added ball, not a drop
            return [messages.Removed(tick=self.world.tick, balls=[landed.ball])]
        return [self._ended(fall, landed.bin, landed.x, landed.t, None)]

    def _settle(self) -> list[messages.Event]:
        """End the drops that rest on the board, and remove their balls."""
        if not self.table.falls:
            return []
        bodies = self.world.bodies
        events: list[messages.Event] = []
        for row in bodies[bodies["asleep"] != 0]:
            fall = self.table.falls.pop(int(row["id"]), None)
            if fall is not None:
                x, time = float(row["x"]), self.world.arena.time
                self.world.arena.remove(fall.start.ball)
                events.append(self._ended(fall, None, x, time, "at rest on the board"))
        return events

    def _ended(
        self, fall: Fall, bin_: int | None, x: float, time: float, unsettled: str | None
    ) -> messages.Landed:
        assert isinstance(self.ground, Board)
        bins = self.ground.bins
        if bin_ is None:
            self.unsettled += 1
        else:
            self.histogram[bin_] += 1
        return messages.Landed(
            ball=fall.start.ball,
            seed=fall.start.seed,
            bin=bin_,
            score=bins.score_of(bin_),
            tick=self.world.tick,
            t=time - fall.time,
            x_end=x,
            digest=None,
            unsettled=unsettled,
            label=bins.label_of(bin_) or msgspec.UNSET,
        )

    # Messages to clients.

    def _asleep(self, bodies: npt.NDArray[np.void]) -> npt.NDArray[np.bool_]:
        # The solver lets a still ball in a hand sleep until the hand's next pull.
        asleep: npt.NDArray[np.bool_] = bodies["asleep"] != 0
        return asleep & ~np.isin(bodies["id"], list(self.world.holds))

    def stream_of(self, wanted: str) -> str:
        """Always snapshots: a path is not known in advance if other balls may cross it."""
        return messages.SNAPSHOTS

    def first_message(self, stream: str) -> bytes:
        """A snapshot, because a room at rest ticks no further and would send none."""
        return self.snapshot(first=True)

    def diagnostics(self) -> messages.Diagnostics:
        found = self.world.arena.diagnostics()
        names = ("kinetic", "potential", "rotational", "total", "px", "py", "angular",
                 "contacts", "penetration", "asleep", "count", "cell")  # fmt: skip
        return messages.Diagnostics(
            tick=self.world.tick,
            time=self.world.arena.time,
            **{name: getattr(found, name) for name in names},
        )

    def _arena_state(self) -> messages.ArenaState:
        arena = self.world.arena
        rows = [arena.ball(ball) for ball in self.world.bodies["id"].tolist()]
        names = ("radius", *BALL_NAMES)
        columns = {"ball": self.world.bodies["id"].tolist()}
        return messages.ArenaState(
            scene=_scene_fields(self.ground),
            place=self.world.place.to_dict(),
            settings=self.table.settings(),
            paused=self.paused,
            owned=self.owned,
            balls=columns | {name: [row[name] for row in rows] for name in names},
            ranges=values.table(**self._usual_ball),
            presets={name: dict(presets) for name, presets in values.PRESETS.items()},
        )

    @property
    def _usual_ball(self) -> dict[str, float]:
        ground = self.ground
        radius = ground.radius if isinstance(ground, Scene) else ground.ball.radius
        return {**self.table.made_of, "radius": radius}

    # Saving.

    def ground_fields(self) -> dict[str, object]:
        """The board or scene at tick 0, as fields of a log."""
        scene = _scene_fields(self.origin)
        board = super().ground_fields() if scene is None else {"board": None}
        return board | {"scene": scene}

    def checkpoint(self) -> bytes:
        """The whole state except the planned inputs, for `restore`."""
        return msgspec.msgpack.encode(
            _Checkpoint(
                world=self.world.snapshot(),
                scene=_scene_fields(self.ground),
                seq=self.seq,
                taken=self.input_count,
                drops=self.drops,
                unsettled=self.unsettled,
                histogram=self.histogram,
                flights=[(fall.start, fall.time) for fall in self.table.falls.values()],
                paused=self.paused,
                steps=self._steps,
                settings=self.table.made_of,
            )
        )

    def restore(self, checkpoint: bytes) -> None:
        """Take over the state in `checkpoint`; raises RecordError if it is not one."""
        try:
            saved = msgspec.msgpack.decode(checkpoint, type=_Checkpoint)
        except msgspec.MsgspecError as error:
            raise RecordError(
                f"the checkpoint is unreadable: {error}", field="checkpoint"
            ) from error
        if saved.scene is not None:
            self._begin_on(Scene(saved.scene))
        self.world.restore(saved.world)
        self._next = None
        self.extent = self.world.extent
        self.seq, self._input_count = saved.seq, saved.taken
        self.drops, self.unsettled = saved.drops, saved.unsettled
        self.histogram = list(saved.histogram)
        self.table.falls = {start.ball: Fall(start, time) for start, time in saved.flights}
        self.paused, self._steps = saved.paused, saved.steps
        self.table.made_of = dict(saved.settings)


def _scene_fields(ground: Ground) -> dict[str, object] | None:
    return ground.to_dict() if isinstance(ground, Scene) else None


def _contacts(
    touches: Iterable[Touch], falls: Mapping[int, Fall], tick: int
) -> list[messages.Contact]:
    """The hardest impacts of a tick in order of time; `t` counts from the ball's drop, if any."""
    loud = sorted((touch for touch in touches if touch.speed >= QUIET), key=lambda it: -it.speed)
    sent = [_contact(touch, falls.get(touch.a), tick) for touch in loud[:_MOST_CONTACTS]]
    return sorted(sent, key=lambda hit: (hit.t, hit.ball))


def _contact(touch: Touch, fall: Fall | None, tick: int) -> messages.Contact:
    return messages.Contact(
        ball=touch.a,
        tick=tick,
        t=touch.t - (fall.time if fall else 0.0),
        x=touch.x,
        y=touch.y,
        kind=_KINDS[touch.kind],
        index=touch.b if touch.kind == "ball" else touch.index,
        speed=touch.speed,
    )
