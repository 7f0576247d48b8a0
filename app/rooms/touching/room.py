"""A room whose balls touch each other, pure: inputs go in, events and frames come out.

Everything that anyone does to it is an input with its tick, so the same inputs at the same ticks
make the same room again, to the last bit: after a crash, and for whoever reads its log.
"""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Literal

import msgspec
import numpy as np

from app.errors import InvalidValueError
from app.protocol import messages, snapshots
from app.rooms.independent import QUIET, DropCommand
from app.rooms.touching import values as arena_values
from app.rooms.touching.checks import BALL_NAMES, InputCheck
from app.rooms.touching.scene import Scene
from app.rooms.touching.world import ArenaWorld
from engine import PHYSICS_VERSION, Board
from engine.constants import KIND_BALL, KIND_PEG, KIND_WALL
from engine.drops.drop import start_of
from engine.errors import RecordError
from engine.multibody.events import ArenaEvent, Landed, Left, Touch
from engine.seeding import parse_seed

INTERACTING: Final = "interacting"
SCENE: Final = "scene"  # how the ledger calls a room without a board
SOLVER: Final[Literal["exact", "stepped"]] = "stepped"

_KINDS: Final = {"peg": KIND_PEG, "wall": KIND_WALL, "ball": KIND_BALL}

_MOST_CONTACTS: Final = 24  # told in one tick, the hardest: more is noise, and costs every client
_VELOCITY_SCALE: Final = 1.0 / 256.0  # m/s; reaches to 128 m/s


@dataclass(frozen=True, slots=True)
class ArenaCommand:
    """An input as it is logged: a checked message, its `type` with it, without a `ref`."""

    data: dict[str, Any]
    who: str | None = None


@dataclass(slots=True, eq=False)
class InputPlan:
    """An input that will be number `number`, carried out at `tick`; `note` is the caller's own."""

    number: int
    tick: int
    command: ArenaCommand
    durable: bool = False
    note: Any = None


@dataclass(slots=True)
class _Flight:
    """A drop on its way down."""

    start: messages.BallStart
    time: float  # s of the arena


class _Checkpoint(msgspec.Struct, frozen=True):
    """A room between two ticks."""

    world: bytes
    scene: dict[str, Any] | None
    seq: int
    taken: int
    drops: int
    unsettled: int
    histogram: list[int]
    flights: list[tuple[messages.BallStart, float]]
    paused: bool
    steps: int
    settings: dict[str, float]


@dataclass(slots=True)
class _Tally:
    """What came of the drops."""

    drops: int = 0
    unsettled: int = 0
    histogram: list[int] = field(default_factory=list)


class ArenaRoom:
    """A scene, or a board with balls that knock each other."""

    def __init__(
        self, room_id: str, ground: Board | Scene, *, tick_rate: int, max_balls: int
    ) -> None:
        self.id = room_id
        self.board = ground
        self.mode = SCENE if isinstance(ground, Scene) else INTERACTING
        self.solver = SOLVER
        self.tick_rate = tick_rate
        self.max_balls = max_balls
        self.tick_time = 0.0  # server time of the last tick, for whoever holds the room to set
        self.seq = 0
        self.taken = 0  # inputs
        self.owned = False  # for whoever holds the room to set
        self.paused = False
        self.touched = False  # changed since the last frame, and not by a tick
        self.planned: deque[InputPlan] = deque()
        self.velocity_scale = _VELOCITY_SCALE
        self._steps = 0  # ticks that a stopped clock still has to run
        self._bounced: set[int] = set()
        self._begin(ground)

    def _begin(self, ground: Board | Scene, tick: int = 0) -> None:
        self.ground = ground
        self.world = ArenaWorld(ground, self.tick_rate)
        self.world.tick = tick
        self.extent = self.world.extent
        bins = ground.bins.count if isinstance(ground, Board) else 0
        self._tally = _Tally(histogram=[0] * bins)
        self._flights: dict[int, _Flight] = {}
        # What the next ball is made of unless told; sliders set it for all.
        self._made_of: dict[str, float] = {
            name: float(arena_values.BALL[name].default or 0.0) for name in BALL_NAMES
        }
        if isinstance(ground, Board):
            for name in BALL_NAMES:
                self._made_of[name] = getattr(ground.ball, name)
        else:
            for name in BALL_NAMES:
                self._made_of[name] = ground.values.get(name, self._made_of[name])

    @property
    def awake(self) -> bool:
        """Whether anything moves, or is about to."""
        if self.planned:
            return True
        return self._steps > 0 if self.paused else self.world.awake

    @property
    def held(self) -> bool:
        """Whether the next tick has to wait until it is known what becomes of a planned input."""
        return bool(self.planned) and self.planned[0].tick <= self.world.tick

    @property
    def drops(self) -> int:
        """Drops taken so far."""
        return self._tally.drops

    @property
    def balls(self) -> list[messages.BallStart]:
        """The drops in flight, by age."""
        return [flight.start for flight in self._flights.values()]

    # Inputs.

    def plan(self, command: DropCommand | ArenaCommand, lead: int = 0) -> InputPlan:
        """Plan an input `lead` ticks from now, or for this very tick where nothing moves.

        Raises InvalidValueError for what cannot be done here, BallLimitError when the room is
        full, the engine's errors for a bad seed or start; the room is then as it was.
        """
        if isinstance(command, DropCommand):
            command = self._drop_input(command)
        data = self._checked(command.data)
        running = self.world.awake and not self.paused
        tick = self.world.tick + lead if running else self.world.tick
        if self.planned:
            tick = max(tick, self.planned[-1].tick)
        number = self.taken + len(self.planned)
        plan = InputPlan(number, tick, ArenaCommand(data, command.who))
        self.planned.append(plan)
        return plan

    def refuse(self, plan: InputPlan) -> None:
        """Take a planned input back, as if it had never been asked for."""
        self.planned.remove(plan)
        for number, later in enumerate(self.planned, self.taken):
            later.number = number

    def enter(self) -> list[tuple[InputPlan, list[messages.Event]]]:
        """Carry out the confirmed inputs whose tick it is; returns what to tell of each."""
        entered: list[tuple[InputPlan, list[messages.Event]]] = []
        while self.planned and self.planned[0].durable and self.held:
            plan = self.planned.popleft()
            entered.append((plan, self._carry_out(plan)))
        return entered

    def take(self, command: DropCommand | ArenaCommand) -> list[messages.Event]:
        """Take an input now, at once; raises what `plan` raises."""
        plan = self.plan(command)
        plan.durable = True
        return self.enter()[-1][1]

    def replay(self, data: dict[str, Any]) -> list[messages.Event]:
        """Take an input that a room has taken before, as it was logged."""
        plan = InputPlan(self.taken, self.world.tick, ArenaCommand(data))
        return self._carry_out(plan)

    def _drop_input(self, command: DropCommand) -> ArenaCommand:
        if not isinstance(self.ground, Board):
            raise InvalidValueError(
                f"room {self.id!r} has no board to drop on: send `add` with x and y", field="type"
            )
        if command.stake:
            raise InvalidValueError(
                f"stake {command.stake}: nothing is staked where others may knock the ball",
                field="stake",
            )
        start_of(self.ground, parse_seed(command.seed), command.x)
        data = {"type": "drop", "seed": str(command.seed), "x": command.x}
        return ArenaCommand(data, command.who)

    def _checked(self, data: dict[str, Any]) -> dict[str, Any]:
        coming = sum(plan.command.data["type"] in ("add", "drop") for plan in self.planned)
        check = InputCheck(
            room_id=self.id,
            ground=self.ground,
            world=self.world,
            tick_rate=self.tick_rate,
            max_balls=self.max_balls,
            coming=coming,
            made_of=self._made_of,
        )
        return check.checked(data)

    def _carry_out(self, plan: InputPlan) -> list[messages.Event]:
        if (plan.number, plan.tick) != (self.taken, self.world.tick):
            raise RuntimeError(f"{plan} came as input {self.taken} at tick {self.world.tick}")
        self.taken += 1
        self.touched = True
        data = dict(plan.command.data)
        kind = data.pop("type")
        if "ball" in data and not self.world.has(data["ball"]):
            return []  # it has landed or was taken out since it was asked for
        events: list[messages.Event] = _ACTS[kind](self, **data)
        self.seq += len(events)
        return events

    def _drop(self, seed: str, x: float | None) -> list[messages.Event]:
        board = self.ground
        assert isinstance(board, Board)
        start = start_of(board, parse_seed(seed), x)
        made = {name: getattr(board.ball, name) for name in ("radius", *BALL_NAMES)}
        ball = self.world.arena.add(start, board.drop.y, **made)
        begun = messages.BallStart(ball, seed, start, self.world.tick)
        self._flights[ball] = _Flight(begun, self.world.arena.time)
        self._tally.drops += 1
        accepted = messages.Accepted(
            ball=ball, seed=seed, x=start, explicit_x=x is not None, tick=self.world.tick
        )
        return [accepted]

    def _add(self, x: float, y: float, **values: float) -> list[messages.Event]:
        motion = {name: values.pop(name) for name in ("vx", "vy", "omega") if name in values}
        ball = self.world.arena.add(x, y, **motion, **values)
        return [messages.Placed(tick=self.world.tick, ball=ball, x=x, y=y, **values)]

    def _kick(self, ball: int, **v: float) -> list[messages.Event]:
        arena = self.world.arena
        arena.kick(ball, v.get("vx", 0.0), v.get("vy", 0.0), v.get("omega", 0.0))
        return []

    def _drag(self, ball: int, x: float, y: float) -> list[messages.Event]:
        self.world.grip(ball, x, y)
        return []

    def _release(self, ball: int) -> list[messages.Event]:
        self.world.release(ball)
        return []

    def _remove(self, ball: int) -> list[messages.Event]:
        self.world.release(ball)
        self.world.arena.remove(ball)
        self._flights.pop(ball, None)
        return [messages.Removed(tick=self.world.tick, balls=[ball])]

    def _clear(self) -> list[messages.Event]:
        gone: list[int] = self.world.bodies["id"].tolist()
        self.world.arena.clear()
        self.world.grips.clear()
        self._flights.clear()
        return [messages.Removed(tick=self.world.tick, balls=gone)]

    def _edit(self, ball: int, **values: float) -> list[messages.Event]:
        self.world.arena.edit(ball, **values)
        return [messages.Edited(tick=self.world.tick, ball=ball, **values)]

    def _set(self, **values: float) -> list[messages.Event]:
        balls: dict[str, float] = {name: values.pop(name) for name in BALL_NAMES if name in values}
        events: list[messages.Event] = []
        if balls:
            self._made_of.update(balls)
            self.world.arena.edit_all(**balls)
            events.append(messages.Edited(tick=self.world.tick, ball=None, **balls))
        if values:
            self.world.arena.configure(**values)
        return [*events, self._told()]

    def _pause(self, paused: bool) -> list[messages.Event]:
        self.paused = paused
        self._steps = 0
        return [self._told()]

    def _step_once(self) -> list[messages.Event]:
        if self.paused:
            self._steps += 1
        return []

    def _reset(self, scene: dict[str, Any] | None = None) -> list[messages.Event]:
        ground = self.ground
        if scene is not None:
            ground = Scene(scene)
        self._begin(ground, self.world.tick)
        return []

    def _told(self) -> messages.RoomSettings:
        return messages.RoomSettings(
            tick=self.world.tick, settings=self._settings(), paused=self.paused
        )

    def _settings(self) -> dict[str, float]:
        now = self.world.arena.settings
        return {name: getattr(now, name) for name in arena_values.SETTINGS} | self._made_of

    # Time.

    def step(self, *, watched: bool) -> list[messages.Event]:
        """One tick on; returns the events to announce, in order."""
        self.world.step()
        if self._steps:
            self._steps -= 1
        events = self._happened(watched)
        events += self._settle()
        self.seq += len(events)
        if watched:
            bodies = self.world.bodies
            self._bounced.update(bodies["id"][bodies["bounced"] != 0].tolist())
        return events

    def _happened(self, watched: bool) -> list[messages.Event]:
        arena = self.world.arena
        happened: Sequence[ArenaEvent]
        if watched and isinstance(self.ground, Board):
            happened = arena.take_events()
        else:
            happened = arena.take_landings()
        events: list[messages.Event] = []
        hits: list[messages.Contact] = []
        for one in happened:
            if isinstance(one, Landed):
                events += self._land(one)
            elif isinstance(one, Left):
                self._flights.pop(one.ball, None)
                events.append(messages.Removed(tick=self.world.tick, balls=[one.ball]))
            elif one.speed >= QUIET:
                hits.append(self._contact(one))
        hits.sort(key=lambda hit: -hit.speed)
        return [*sorted(hits[:_MOST_CONTACTS], key=lambda hit: (hit.t, hit.ball)), *events]

    def _contact(self, touch: Touch) -> messages.Contact:
        flight = self._flights.get(touch.a)
        return messages.Contact(
            ball=touch.a,
            tick=self.world.tick,
            t=touch.t - (flight.time if flight else 0.0),
            x=touch.x,
            y=touch.y,
            kind=_KINDS[touch.kind],
            index=touch.b if touch.kind == "ball" else touch.index,
            speed=touch.speed,
        )

    def _land(self, landed: Landed) -> list[messages.Event]:
        flight = self._flights.pop(landed.ball, None)
        if flight is None:  # one that was thrown in: nobody's drop
            return [messages.Removed(tick=self.world.tick, balls=[landed.ball])]
        return [self._ended(flight, landed.bin, landed.x, landed.t, None)]

    def _settle(self) -> list[messages.Event]:
        """Drops that came to rest on the board have ended; they are taken off it."""
        if not self._flights:
            return []
        bodies = self.world.bodies
        events: list[messages.Event] = []
        for row in bodies[bodies["asleep"] != 0]:
            flight = self._flights.pop(int(row["id"]), None)
            if flight is not None:
                x, time = float(row["x"]), self.world.arena.time
                self.world.arena.remove(flight.start.ball)
                events.append(self._ended(flight, None, x, time, "at rest on the board"))
        return events

    def _ended(
        self, flight: _Flight, bin_: int | None, x: float, time: float, unsettled: str | None
    ) -> messages.Landed:
        score = 1.0
        if bin_ is None:
            self._tally.unsettled += 1
        else:
            assert isinstance(self.ground, Board)
            self._tally.histogram[bin_] += 1
            score = self.ground.bins.multipliers[bin_]
        return messages.Landed(
            ball=flight.start.ball,
            seed=flight.start.seed,
            bin=bin_,
            score=score,
            tick=self.world.tick,
            t=time - flight.time,
            x_end=x,
            digest=None,
            unsettled=unsettled,
        )

    # What is told.

    def frame(self, *, first: bool = False) -> bytes:
        """The snapshot of this moment; bounces are flagged since the frame before.

        The `first` one that a client gets is no news to the others.
        """
        bodies = self.world.bodies
        bounced = np.isin(bodies["id"], list(self._bounced))
        if not first:
            self.touched = False
            self._bounced.clear()
        asleep = bodies["asleep"] != 0
        return snapshots.encode_snapshot(
            self.world.tick, self.seq, bodies, bounced, self.extent, self.velocity_scale, asleep
        )

    def diagnostics(self) -> messages.Diagnostics:
        """Energies, momenta, contacts of this moment; computed here, for whoever asked."""
        found = self.world.arena.diagnostics()
        names = ("kinetic", "potential", "rotational", "total", "px", "py", "angular",
                 "contacts", "penetration", "asleep", "count")  # fmt: skip
        return messages.Diagnostics(
            tick=self.world.tick,
            time=self.world.arena.time,
            **{name: getattr(found, name) for name in names},
        )

    def stream_of(self, wanted: str) -> str:
        """Only snapshots: nobody knows a path beforehand that others will cross."""
        return messages.SNAPSHOTS

    def stats(self) -> messages.Stats:
        """What has come of the drops."""
        tally = self._tally
        return messages.Stats(tally.drops, list(tally.histogram), tally.unsettled)

    def hello(
        self, server_time: float, limits: messages.Limits, stream: str = messages.SNAPSHOTS
    ) -> messages.Hello:
        """The full state but for the places of the balls, which the next snapshot has."""
        board = self.ground if isinstance(self.ground, Board) else None
        return messages.Hello(
            protocol=messages.PROTOCOL_VERSION,
            physics_version=PHYSICS_VERSION,
            room=self.id,
            board_name=self.ground.name,
            board_digest=self.ground.digest,
            board=msgspec.Raw(msgspec.json.encode(board.to_dict() if board else None)),
            slots=list(board.slots) if board else [],
            solver=SOLVER,
            mode=INTERACTING,
            tick_rate=self.tick_rate,
            tick=self.world.tick,
            seq=self.seq,
            server_time=server_time,
            extent=self.extent,
            velocity_scale=self.velocity_scale,
            spin_scale=self.velocity_scale,
            stream=messages.SNAPSHOTS,
            limits=msgspec.structs.replace(limits, balls=self.max_balls),
            balls=self.balls,
            stats=self.stats(),
            arena=self._state(),
        )

    def _state(self) -> messages.ArenaState:
        arena = self.world.arena
        rows = [arena.ball(ball) for ball in self.world.bodies["id"].tolist()]
        names = ("radius", *BALL_NAMES)
        columns = {"ball": self.world.bodies["id"].tolist()}
        return messages.ArenaState(
            scene=self.ground.to_dict() if isinstance(self.ground, Scene) else None,
            place=arena.place.to_dict(),
            settings=self._settings(),
            paused=self.paused,
            owned=self.owned,
            balls=columns | {name: [row[name] for row in rows] for name in names},
            ranges=arena_values.table(),
            presets={name: dict(values) for name, values in arena_values.PRESETS.items()},
        )

    # Saving.

    def checkpoint(self) -> bytes:
        """All that `restore` needs but the planned inputs."""
        tally = self._tally
        return msgspec.msgpack.encode(
            _Checkpoint(
                world=self.world.snapshot(),
                scene=self.ground.to_dict() if isinstance(self.ground, Scene) else None,
                seq=self.seq,
                taken=self.taken,
                drops=tally.drops,
                unsettled=tally.unsettled,
                histogram=tally.histogram,
                flights=[(flight.start, flight.time) for flight in self._flights.values()],
                paused=self.paused,
                steps=self._steps,
                settings=self._made_of,
            )
        )

    def restore(self, checkpoint: bytes) -> None:
        """Become the room that made `checkpoint`; raises RecordError when it is another's."""
        try:
            saved = msgspec.msgpack.decode(checkpoint, type=_Checkpoint)
        except msgspec.MsgspecError as error:
            raise RecordError(f"the checkpoint is none: {error}", field="checkpoint") from error
        if saved.scene is not None:
            self._begin(Scene(saved.scene))
        self.world.restore(saved.world)
        self.extent = self.world.extent
        self.seq, self.taken = saved.seq, saved.taken
        self._tally = _Tally(saved.drops, saved.unsettled, list(saved.histogram))
        self._flights = {start.ball: _Flight(start, time) for start, time in saved.flights}
        self.paused, self._steps = saved.paused, saved.steps
        self._made_of = dict(saved.settings)


_ACTS: Final[dict[str, Callable[..., list[messages.Event]]]] = {
    "drop": ArenaRoom._drop,
    "add": ArenaRoom._add,
    "kick": ArenaRoom._kick,
    "drag": ArenaRoom._drag,
    "release": ArenaRoom._release,
    "remove": ArenaRoom._remove,
    "clear": ArenaRoom._clear,
    "edit": ArenaRoom._edit,
    "settings": ArenaRoom._set,
    "pause": ArenaRoom._pause,
    "step": ArenaRoom._step_once,
    "reset": ArenaRoom._reset,
}
