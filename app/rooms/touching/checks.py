"""What an input to a room whose balls touch must be before it is written down. Pure."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from app.errors import BallLimitError, InvalidValueError, MissingBallError, shorten
from app.rooms.touching import values as arena_values
from app.rooms.touching.scene import Scene
from app.rooms.touching.world import ArenaWorld
from engine import Board

BALL_NAMES: Final = ("density", "restitution", "friction")


@dataclass(frozen=True, slots=True)
class InputCheck:
    """A room as far as an input is judged by it; `coming`: balls that planned inputs will add.

    made_of: of what a ball is that is put in without saying so.
    """

    room_id: str
    ground: Board | Scene
    world: ArenaWorld
    tick_rate: int
    max_balls: int
    coming: int
    made_of: Mapping[str, float]

    def checked(self, data: dict[str, Any]) -> dict[str, Any]:
        """The input with its values made numbers.

        Raises InvalidValueError, MissingBallError, and BallLimitError when the room is full.
        """
        kind = data["type"]
        rest = {key: value for key, value in data.items() if key != "type" and value is not None}
        if kind in ("add", "drop"):
            self._check_place()
        if kind == "drop":
            return data
        if "ball" in rest and kind != "release":
            self._check_ball(rest["ball"])
        return {"type": kind, **_CHECKS[kind](self, rest)}

    def _check_place(self) -> None:
        if self.world.count + self.coming >= self.max_balls:
            raise BallLimitError(f"room {self.room_id!r} already holds {self.max_balls} balls")
        settings = self.world.arena.settings
        arena_values.check_work(
            self.world.count + self.coming + 1, settings.dt, settings.substeps, self.tick_rate
        )

    def _check_ball(self, ball: int) -> None:
        if not self.world.has(ball):
            raise MissingBallError(f"there is no ball {ball} in the room", field="ball")

    def _check_add(self, rest: dict[str, Any]) -> dict[str, Any]:
        values = arena_values.checked(rest, arena_values.BALL, arena_values.MOTION)
        self._check_given(values, "x", "y")
        usual = self.ground.radius if isinstance(self.ground, Scene) else self.ground.ball.radius
        radius = values.setdefault("radius", usual)
        self._check_within(values["x"], values["y"], radius)
        return {**self.made_of, **values}

    def _check_given(self, values: dict[str, float], *names: str) -> None:
        for name in names:
            if name not in values:
                raise InvalidValueError(f"{name} is missing", field=name)

    def _check_within(self, x: float, y: float, margin: float) -> None:
        """Raise unless a place lies inside what does not move; boards are open above."""
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

    def _check_kick(self, rest: dict[str, Any]) -> dict[str, Any]:
        ball = rest.pop("ball")
        return {"ball": ball, **arena_values.checked(rest, arena_values.MOTION)}

    def _check_drag(self, rest: dict[str, Any]) -> dict[str, Any]:
        values = self._check_kick(rest)
        self._check_given(values, "x", "y")
        # A pointer may leave the box; the hand stays inside.
        box = self.world.extent
        values["x"] = min(max(values["x"], box.x_min), box.x_max)
        values["y"] = min(max(values["y"], box.y_min - 2.0), box.y_max)
        return values

    def _check_edit(self, rest: dict[str, Any]) -> dict[str, Any]:
        ball = rest.pop("ball")
        values = arena_values.checked(rest, arena_values.BALL)
        if not values:
            known = ", ".join(arena_values.BALL)
            raise InvalidValueError(f"an edit of ball {ball} sets none of: {known}", field="type")
        return {"ball": ball, **values}

    def _check_settings(self, rest: dict[str, Any]) -> dict[str, Any]:
        ranges = {name: arena_values.BALL[name] for name in BALL_NAMES}
        values = arena_values.checked(rest, arena_values.SETTINGS, ranges)
        now = self.world.arena.settings
        dt, substeps = values.get("dt", now.dt), values.get("substeps", now.substeps)
        arena_values.check_work(self.world.count, dt, substeps, self.tick_rate)
        return values

    def _check_reset(self, rest: dict[str, Any]) -> dict[str, Any]:
        wanted = rest.get("scene")
        if wanted is None:
            return {}
        if not isinstance(self.ground, Scene):
            raise InvalidValueError(
                f"scene {shorten(wanted)}: this room has a board, which stays", field="scene"
            )
        scene = Scene.of(wanted, tick_rate=self.tick_rate, max_balls=self.max_balls)
        return {"scene": scene.to_dict()}


def _as_is(check: InputCheck, rest: dict[str, Any]) -> dict[str, Any]:
    return rest


_CHECKS: Final[dict[str, Callable[[InputCheck, dict[str, Any]], dict[str, Any]]]] = {
    "add": InputCheck._check_add,
    "kick": InputCheck._check_kick,
    "drag": InputCheck._check_drag,
    "edit": InputCheck._check_edit,
    "settings": InputCheck._check_settings,
    "reset": InputCheck._check_reset,
    "release": _as_is,
    "remove": _as_is,
    "clear": _as_is,
    "pause": _as_is,
    "step": _as_is,
}
