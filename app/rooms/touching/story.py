"""A box that somebody played alone, as it is told: its scene, and all that was done to it. Pure.

A page computes a box of its own by the kernels that a room has, so the same inputs at the same
ticks make a room in which every ball is where it was there, to the last bit.
"""

import math
from dataclasses import dataclass
from typing import Annotated, Final

import msgspec
from msgspec import Meta

from app.errors import AppError, InvalidValueError, shorten
from app.protocol import touching_messages as wire
from app.rooms.pending import PendingInput
from app.rooms.touching.inputs import TouchingCommand
from app.rooms.touching.room import TouchingRoom
from app.rooms.touching.scene import Scene
from engine.constants import PHYSICS_VERSION
from engine.json_text import Json, JsonObject

MOST_INPUTS: Final = 10_000

LEAST_BALLS: Final = 30
"""Some 80 us a tick in 4 substeps, as one ball takes."""


class StoryEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What was done, in the form of a room's log, and at which tick."""

    tick: Annotated[int, Meta(ge=0)]
    input: Annotated[
        JsonObject,
        Meta(description="A message as over the WebSocket, but `drop` and `reset`."),
    ]


class StoryForm(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A box as it is told."""

    scene: Annotated[
        Json,
        Meta(
            description="As for a room.",
            examples=[{"scene": "sandbox", "balls": 40}],
            extra_json_schema={"anyOf": [{"type": "string"}, {"type": "object"}]},
        ),
    ]
    tick_rate: Annotated[int, Meta(description="Ticks a second; the server's own.")]
    physics_version: Annotated[int, Meta(description="By which it was computed.")]
    tick: Annotated[int, Meta(ge=0, description="At which the room goes on.")]
    inputs: Annotated[
        list[StoryEntry],
        Meta(description=f"In the order of time; {MOST_INPUTS:,} at most."),
    ]


@dataclass(frozen=True, slots=True)
class Story:
    """What `retell` makes a room of; checked as far as can be without telling it."""

    scene: Scene
    tick: int
    changes: tuple[tuple[int, wire.Change], ...]

    @property
    def most_balls(self) -> int:
        """That can have been in it at a time."""
        added = sum(isinstance(change, wire.AddMessage) for _, change in self.changes)
        return int(self.scene.values["balls"]) + added

    def ball_substeps(self, tick_rate: int) -> float:
        """What telling it takes: a tick of however few balls costs as much as of `LEAST_BALLS`."""
        return self.tick / tick_rate * self.substeps * max(self.most_balls, LEAST_BALLS)

    @property
    def substeps(self) -> float:
        """Of a second, at most, by the finest settings that were made."""
        told = [dict(self.scene.values)]
        told += [msgspec.structs.asdict(change) for _, change in self.changes]
        steps: float = min(_positive(each.get("dt"), math.inf) for each in told)
        return max(_positive(each.get("substeps"), 0.0) for each in told) / steps


def _positive(value: object, otherwise: float) -> float:
    """A number above 0 as it is; what is none is refused when the story is told."""
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return float(value) if is_number and value > 0 else otherwise  # type: ignore[arg-type, operator]


@dataclass(frozen=True, slots=True)
class Retold:
    """A room as a story has left it: its checkpoint, and the inputs it has taken, as kept."""

    scene: Scene
    checkpoint: bytes
    inputs: tuple[PendingInput[TouchingCommand], ...]


def story_of(form: StoryForm, *, tick_rate: int, max_balls: int) -> Story:
    """A story of what a client sent; raises InvalidValueError that names what is wrong in it."""
    for name, ours in (("tick_rate", tick_rate), ("physics_version", PHYSICS_VERSION)):
        theirs = getattr(form, name)
        if theirs != ours:
            raise InvalidValueError(f"{name} {theirs} is not this server's {ours}", field=name)
    if len(form.inputs) > MOST_INPUTS:
        raise InvalidValueError(
            f"{len(form.inputs)} inputs are more than {MOST_INPUTS}", field="inputs"
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
            f"{where}.input is a reset: what was before it needs no telling", field=f"{where}.input"
        )
    return change


def retell(story: Story, *, tick_rate: int, max_balls: int) -> Retold:
    """The room that a story ends in; takes as long as its ticks. For a worker.

    Raises InvalidValueError that names the input which such a room would not have taken.
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
