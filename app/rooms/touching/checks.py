"""Validates a client's message to a room of touching balls and turns it into an input. Pure.

This is the only place where that happens: every value of an input is a number within its range.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final, TypeVar

import msgspec
import numpy as np
import numpy.typing as npt

from plinko.app.errors import BallLimitError, InvalidValueError, MissingBallError
from plinko.app.protocol import touching_messages as wire
from plinko.app.protocol.visitors import NO_TAG
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.touching import inputs, values
from plinko.app.rooms.touching.scene import Scene
from plinko.app.rooms.touching.world import TouchingWorld
from plinko.engine import Board
from plinko.engine.drops.start import start_of
from plinko.engine.errors import shorten

Changing = TypeVar("Changing", bound=wire.Change)

MOST_OVERLAPS: Final = 32
"""Balls that an added ball may overlap."""


@dataclass(frozen=True, slots=True)
class Spot:
    """The place of a ball that exists or will be added, in m."""

    x: float
    y: float
    radius: float


def spot_of(asked: inputs.TouchingInput, ground: Board | Scene) -> Spot | None:
    """Where an input will add a ball; None if it adds none."""
    if isinstance(asked, wire.AddMessage):
        return Spot(asked.x, asked.y, asked.radius)
    if isinstance(asked, inputs.Drop) and isinstance(ground, Board):
        return Spot(asked.start(ground), ground.drop.y, ground.ball.radius)
    return None


def check_room(spot: Spot, bodies: npt.NDArray[np.void], coming: Iterable[Spot]) -> None:
    """Raise BallLimitError if a ball would overlap too many of `bodies` and `coming`."""
    reach = bodies["radius"] + spot.radius
    across, down = bodies["x"] - spot.x, bodies["y"] - spot.y
    overlaps = int((across * across + down * down < reach * reach).sum())
    overlaps += sum(_overlap(spot, other) for other in coming)
    if overlaps > MOST_OVERLAPS:
        raise BallLimitError(
            f"{overlaps} balls are at ({spot.x:g}, {spot.y:g}) m already, and a new ball may "
            f"overlap at most {MOST_OVERLAPS}: choose another place, or wait until they have gone",
            field="x",
        )


def _overlap(one: Spot, other: Spot) -> bool:
    across, down, reach = one.x - other.x, one.y - other.y, one.radius + other.radius
    return across * across + down * down < reach * reach


BALL_NAMES: Final = ("density", "restitution", "friction")


def no_such_ball(ball: int) -> MissingBallError:
    """The error for a ball that never existed, or has landed or been removed meanwhile."""
    return MissingBallError(f"there is no ball {ball} in the room", field="ball")


@dataclass(frozen=True, slots=True)
class InputCheck:
    """The state of a room that decides whether an input is valid.

    coming: where planned inputs will add balls.
    made_of: defaults for the material of an added ball.
    """

    room_id: str
    ground: Board | Scene
    world: TouchingWorld
    tick_rate: int
    max_balls: int
    coming: tuple[Spot, ...]
    made_of: Mapping[str, float]

    def change(self, message: wire.Change) -> wire.Change:
        """The input for a client's message.

        Raises InvalidValueError, MissingBallError, and BallLimitError when the room is full.
        """
        ball = getattr(message, "ball", None)
        if ball is not None and not self.world.has(ball):
            raise no_such_ball(ball)
        found: wire.Change
        match message:
            case wire.AddMessage():
                found = self._add(message)
            case wire.KickMessage():
                found = _with(message, _numbers(message, values.MOTION))
            case wire.DragMessage():
                found = self._drag(message)
            case wire.EditMessage():
                found = self._edit(message)
            case wire.SettingsMessage():
                found = self._configure(message)
            case wire.ResetMessage():
                found = self._reset(message)
            case _:
                found = _with(message, {})
        return found

    def drop(self, command: DropCommand) -> inputs.Drop:
        """The input for a drop; raises what `change` raises, and SeedError or ParameterError."""
        if not isinstance(self.ground, Board):
            raise InvalidValueError(
                f"room {self.room_id!r} has no board to drop on: send `add` with x and y",
                field="type",
            )
        if command.stake:
            raise InvalidValueError(
                f"stake {command.stake}: a ball that others may knock takes no stake; leave it out",
                field="stake",
            )
        if command.tag != NO_TAG:
            raise InvalidValueError(
                f"the balls in room {self.room_id!r} touch each other and have no names or "
                "colours: leave both out",
                field="name" if command.tag.name else "colour",
            )
        start = start_of(self.ground, command.seed, command.x, command.aim)
        self._check_place(Spot(start, self.ground.drop.y, self.ground.ball.radius))
        aim = msgspec.UNSET if command.aim is None else command.aim
        return inputs.Drop(seed=str(command.seed), x=command.x, aim=aim)

    def _check_place(self, spot: Spot) -> None:
        count = self.world.count + len(self.coming)
        if count >= self.max_balls:
            raise BallLimitError(f"room {self.room_id!r} already has {self.max_balls} balls")
        settings = self.world.arena.settings
        values.check_work(count + 1, settings.dt, settings.substeps, self.tick_rate)
        check_room(spot, self.world.bodies, self.coming)

    def _add(self, asked: wire.AddMessage) -> wire.AddMessage:
        found = _numbers(asked, values.BALL, values.MOTION)
        self._check_given(found, "x", "y")
        usual = self.ground.radius if isinstance(self.ground, Scene) else self.ground.ball.radius
        radius = found.setdefault("radius", usual)
        self._check_within(found["x"], found["y"], radius)
        self._check_place(Spot(found["x"], found["y"], radius))
        return _with(asked, {**self.made_of, **found})

    def _check_given(self, found: dict[str, float], *names: str) -> None:
        for name in names:
            if name not in found:
                raise InvalidValueError(f"{name} is missing", field=name)

    def _check_within(self, x: float, y: float, margin: float) -> None:
        """Raise InvalidValueError for a place outside the walls; boards are open at the top."""
        box = self.world.extent
        top = box.y_min + margin if isinstance(self.ground, Scene) else box.y_min - 2.0
        if not box.x_min + margin <= x <= box.x_max - margin:
            raise InvalidValueError(
                f"x {x!r} is not from {box.x_min + margin:g} to {box.x_max - margin:g} m", field="x"
            )
        if not top <= y <= box.y_max - margin:
            raise InvalidValueError(
                f"y {y!r} is not from {top:g} to {box.y_max - margin:g} m", field="y"
            )

    def _drag(self, asked: wire.DragMessage) -> wire.DragMessage:
        found = _numbers(asked, values.MOTION)
        self._check_given(found, "x", "y")
        # A pointer may leave the box; the hand stays inside.
        box = self.world.extent
        x = min(max(found["x"], box.x_min), box.x_max)
        y = min(max(found["y"], box.y_min - 2.0), box.y_max)
        return _with(asked, {"x": x, "y": y})

    def _edit(self, asked: wire.EditMessage) -> wire.EditMessage:
        found = _numbers(asked, values.BALL)
        if not found:
            known = ", ".join(values.BALL)
            raise InvalidValueError(
                f"the edit of ball {asked.ball} sets none of: {known}; give at least one",
                field="type",
            )
        return _with(asked, found)

    def _configure(self, asked: wire.SettingsMessage) -> wire.SettingsMessage:
        ranges = {name: values.BALL[name] for name in BALL_NAMES}
        found = _numbers(asked, values.SETTINGS, ranges)
        now = self.world.arena.settings
        dt, substeps = found.get("dt", now.dt), found.get("substeps", now.substeps)
        values.check_work(self.world.count, dt, substeps, self.tick_rate)
        return _with(asked, found)

    def _reset(self, asked: wire.ResetMessage) -> wire.ResetMessage:
        wanted = asked.scene
        if wanted is None:
            return wire.ResetMessage()
        if not isinstance(self.ground, Scene):
            raise InvalidValueError(
                f"scene {shorten(wanted)}: this room has a board, which a scene cannot replace",
                field="scene",
            )
        scene = Scene.of(wanted, tick_rate=self.tick_rate, max_balls=self.max_balls)
        return wire.ResetMessage(scene=scene.to_dict())


def _with(message: Changing, numbers: dict[str, Any]) -> Changing:
    """The message as an input, with these numbers."""
    return msgspec.structs.replace(message, ref=None, **numbers)


def _numbers(asked: wire.Change, *tables: Mapping[str, values.Range]) -> dict[str, Any]:
    """The values of a message, by name, as numbers within the ranges of `tables`."""
    said = msgspec.structs.asdict(asked)
    return values.checked({k: v for k, v in said.items() if k not in ("ref", "ball")}, *tables)
