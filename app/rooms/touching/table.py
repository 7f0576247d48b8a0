"""A board or scene with its balls, and the code that carries out inputs on them. Pure."""

from dataclasses import dataclass

from plinko.app.protocol import messages
from plinko.app.protocol import touching_messages as wire
from plinko.app.rooms.touching import inputs, values
from plinko.app.rooms.touching.checks import BALL_NAMES
from plinko.app.rooms.touching.inputs import given
from plinko.app.rooms.touching.scene import Scene
from plinko.app.rooms.touching.world import TouchingWorld
from plinko.engine import Board


@dataclass(slots=True)
class Fall:
    """A drop in flight."""

    start: messages.BallStart
    time: float  # the arena's time at the drop, s


class Table:
    """The board or scene and its balls, from `tick` until a reset replaces the whole table.

    falls: the drops in flight, by ball.
    made_of: the default material of an added ball; a change of settings sets it for all.
    """

    def __init__(self, ground: Board | Scene, tick_rate: int, tick: int) -> None:
        self.ground = ground
        self.world = TouchingWorld(ground, tick_rate)
        self.world.tick = tick
        self.falls: dict[int, Fall] = {}
        self.made_of = _made_of(ground)
        # What settings change of pegs and walls too. In a scene they have no restitution.
        on_board = isinstance(ground, Board)
        self._shared = ("restitution", "friction") if on_board else ("friction",)

    def carry_out(self, asked: inputs.TouchingInput) -> list[messages.Event]:
        """Carry out an input; returns the events to announce."""
        world, arena, tick = self.world, self.world.arena, self.world.tick
        events: list[messages.Event] = []
        match asked:
            case inputs.Drop():
                events.append(self._drop(asked))
            case wire.AddMessage():
                made_of = given(asked, "vx", "vy", "omega")
                events.append(messages.Placed(tick=tick, ball=arena.add(**given(asked)), **made_of))
            case wire.KickMessage():
                motion = {"vx": 0.0, "vy": 0.0, "omega": 0.0} | given(asked, "ball")
                arena.kick(asked.ball, motion["vx"], motion["vy"], motion["omega"])
            case wire.DragMessage():
                world.hold(asked.ball, asked.x, asked.y)
            case wire.ReleaseMessage():
                world.release(asked.ball)
            case wire.RemoveMessage():
                world.release(asked.ball)
                arena.remove(asked.ball)
                self.falls.pop(asked.ball, None)
                events.append(messages.Removed(tick=tick, balls=[asked.ball]))
            case wire.ClearMessage():
                events.append(messages.Removed(tick=tick, balls=world.bodies["id"].tolist()))
                arena.clear()
                world.holds.clear()
                self.falls.clear()
            case wire.EditMessage():
                changes = given(asked, "ball")
                arena.edit(asked.ball, **changes)
                events.append(messages.Edited(tick=tick, ball=asked.ball, **changes))
            case wire.SettingsMessage():
                events += self._configure(asked)
        return events

    def settings(self) -> dict[str, float]:
        """The arena's settings and the default material of a ball."""
        return values.of_arena(self.world.arena.settings) | self.made_of

    def _configure(self, asked: wire.SettingsMessage) -> list[messages.Event]:
        of_balls, of_room = given(asked, *values.SETTINGS), given(asked, *BALL_NAMES)
        events: list[messages.Event] = []
        if of_balls:
            self.made_of.update(of_balls)
            self.world.arena.edit_all(**of_balls)
            fixed = {name: of_balls[name] for name in self._shared if name in of_balls}
            if fixed:
                self.world.arena.edit_place(**fixed)
            events.append(messages.Edited(tick=self.world.tick, ball=None, **of_balls))
        if of_room:
            self.world.arena.configure(**values.for_arena(of_room))
        return events

    def _drop(self, asked: inputs.Drop) -> messages.Accepted:
        board, tick = self.ground, self.world.tick
        assert isinstance(board, Board)
        start = asked.start(board)
        made = {name: getattr(board.ball, name) for name in ("radius", *BALL_NAMES)}
        ball = self.world.arena.add(start, board.drop.y, **made)
        begun = messages.BallStart(ball, asked.seed, start, tick)
        self.falls[ball] = Fall(begun, self.world.arena.time)
        return messages.Accepted(
            ball=ball,
            seed=asked.seed,
            x=start,
            explicit_x=asked.x is not None,
            aim=asked.aim,
            tick=tick,
        )


def _made_of(ground: Board | Scene) -> dict[str, float]:
    """The default material of a ball on this board or scene."""
    if isinstance(ground, Board):
        return {name: getattr(ground.ball, name) for name in BALL_NAMES}
    usual = {name: float(values.BALL[name].default or 0.0) for name in BALL_NAMES}
    return {name: ground.values.get(name, usual[name]) for name in BALL_NAMES}
