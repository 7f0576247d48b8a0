"""Stories: a scene that was played in a page, with all its inputs, becomes a room. Pure.

The sandbox page computes with the kernels that a room uses. Replaying the same inputs at the same
ticks therefore gives a room in which every ball is where it was in the page, to the last bit.
"""

import math
from dataclasses import dataclass
from typing import Annotated, Final

import msgspec
from msgspec import Meta

from plinko.app.errors import AppError, InvalidValueError
from plinko.app.protocol import touching_messages as wire
from plinko.app.rooms.pending import PendingInput
from plinko.app.rooms.touching.inputs import TouchingCommand
from plinko.app.rooms.touching.room import TouchingRoom
from plinko.app.rooms.touching.scene import Scene
from plinko.engine.constants import PHYSICS_VERSION
from plinko.engine.errors import shorten
from plinko.engine.json_text import Json, JsonObject

MOST_INPUTS: Final = 10_000

LEAST_BALLS: Final = 30
"""A tick of fewer balls costs as much as of this many: some 80 us in 4 substeps."""


class StoryEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An input and its tick, in the form of a room's log."""

    tick: Annotated[int, Meta(ge=0)]
    input: Annotated[
        JsonObject,
        Meta(description="A message as over the WebSocket, except `drop` and `reset`."),
    ]


class StoryForm(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A scene that was played elsewhere, with its inputs."""

    scene: Annotated[
        Json,
        Meta(
            description="A scene, as for a room.",
            examples=[{"scene": "sandbox", "balls": 40}],
            extra_json_schema={"anyOf": [{"type": "string"}, {"type": "object"}]},
        ),
    ]
    tick_rate: Annotated[int, Meta(description="Ticks a second; must be the server's.")]
    physics_version: Annotated[int, Meta(description="Must be the server's.")]
    tick: Annotated[int, Meta(ge=0, description="The tick at which the room continues.")]
    inputs: Annotated[
        list[StoryEntry],
        Meta(description=f"In the order of time; at most {MOST_INPUTS:,}."),
    ]


@dataclass(frozen=True, slots=True)
class Story:
    """A story, validated except for what only `retell` can find by replaying it."""

    scene: Scene
    tick: int
    changes: tuple[tuple[int, wire.Change], ...]

    @property
    def most_balls(self) -> int:
        """An upper bound of the balls in the scene at a time."""
        added = sum(isinstance(change, wire.AddMessage) for _, change in self.changes)
        return int(self.scene.values["balls"]) + added

    def ball_substeps(self, tick_rate: int) -> float:
        """An upper bound of the work to replay it, in balls times substeps."""
        return self.tick / tick_rate * self.substeps * max(self.most_balls, LEAST_BALLS)

    @property
    def substeps(self) -> float:
        """Substeps a second by the finest settings in the story."""
        settings = [dict(self.scene.values)]
        settings += [msgspec.structs.asdict(change) for _, change in self.changes]
        dt: float = min(_positive(each.get("dt"), math.inf) for each in settings)
        return max(_positive(each.get("substeps"), 0.0) for each in settings) / dt


def _positive(value: object, otherwise: float) -> float:
    """`value` if it is a number above 0, or `otherwise`; `retell` refuses invalid values."""
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return float(value) if is_number and value > 0 else otherwise  # type: ignore[arg-type, operator]


@dataclass(frozen=True, slots=True)
class Retold:
    """The room at the end of a story: its checkpoint, and the inputs that it has taken."""

    scene: Scene
    checkpoint: bytes
    inputs: tuple[PendingInput[TouchingCommand], ...]


def story_of(form: StoryForm, *, tick_rate: int, max_balls: int) -> Story:
    """Validate a client's story; raises InvalidValueError that names the invalid part."""
    for name, ours in (("tick_rate", tick_rate), ("physics_version", PHYSICS_VERSION)):
        theirs = getattr(form, name)
        if theirs != ours:
            raise InvalidValueError(f"{name} {theirs} is not this server's {ours}", field=name)
    if len(form.inputs) > MOST_INPUTS:
        raise InvalidValueError(
            f"inputs has {len(form.inputs)} entries; at most {MOST_INPUTS} are allowed",
            field="inputs",
        )
    scene = Scene.of(form.scene, tick_rate=tick_rate, max_balls=max_balls)
    before, changes = 0, []
    for number, entry in enumerate(form.inputs):
        where = f"inputs[{number}]"
        if not before <= entry.tick <= form.tick:
            raise InvalidValueError(
                f"{where}.tick {entry.tick} is not from {before} to {form.tick}",
                field=f"{where}.tick",
            )
        before = entry.tick
        changes.append((entry.tick, _change(entry.input, where)))
    return Story(scene, form.tick, tuple(changes))


def _change(asked: JsonObject, where: str) -> wire.Change:
    try:
        change: wire.Change = msgspec.convert(asked, wire.Change)
    except msgspec.ValidationError as error:
        raise InvalidValueError(f"{where}.input: {error}", field=f"{where}.input") from error
    if isinstance(change, wire.ResetMessage):
        raise InvalidValueError(
            f"{where}.input is a reset: leave out the reset and all inputs before it",
            field=f"{where}.input",
        )
    return change


def retell(story: Story, *, tick_rate: int, max_balls: int) -> Retold:
    """Replay a story's inputs and ticks in a new room. Run it in a worker: it may take minutes.

    Raises InvalidValueError that names the first input that the room refuses.
    """
    room = TouchingRoom("story", story.scene, tick_rate=tick_rate, max_balls=max_balls)
    taken: list[PendingInput[TouchingCommand]] = []
    for number, (tick, change) in enumerate(story.changes):
        _run(room, tick)
        try:
            pending = room.plan_change(change)
        except AppError as error:
            where = f"inputs[{number}]"
            raise InvalidValueError(f"{where} {shorten(error)}", field=where) from error
        pending.durable = True
        room.enter()
        taken.append(pending)
    _run(room, story.tick)
    return Retold(story.scene, room.checkpoint(), tuple(taken))


def _run(room: TouchingRoom, tick: int) -> None:
    while room.world.tick < tick:
        room.step(watched=False)
