"""Logs of played rooms, as a server exports them, made without a server."""

from collections.abc import Sequence
from typing import Any

import msgspec

from plinko.app.protocol.touching_messages import Change
from plinko.app.protocol.visitors import Tag
from plinko.app.rooms import log as roomlog
from plinko.app.rooms.independent import IndependentRoom
from plinko.app.rooms.pending import DropCommand, Pending
from plinko.app.rooms.records import InputRow, ResultRow
from plinko.app.rooms.room import Room
from plinko.app.rooms.touching.room import TouchingRoom
from plinko.app.rooms.touching.scene import Scene
from plinko.engine import Board

Log = dict[str, Any]

TICKS = 60
OWN = {
    "name": "own",
    "gravity": 10.0,
    "ball": {"radius": 0.1, "density": 1.0, "friction": 0.2},
    "pegs": [{"x": 0.0, "y": 2.0, "radius": 0.25}],
    "bins": {"edges": [-1.0, 0.0, 1.0], "multipliers": [2.0, 0.5]},
    "drop": {"jitter": 0.5, "reach": 0.7, "aim": 0.2},
}
SCENE = {"scene": "sandbox", "balls": 3, "width": 3.0, "height": 2.0, "radii": [0.1, 0.125]}


def of_drops() -> Log:
    """Drops of independent balls that use every field of a log.

    Landed and in flight; by seed, aim and x; staked, practice and neither.
    """
    room = IndependentRoom("own-room", Board.from_json(OWN), tick_rate=TICKS, max_balls=9)
    rows: list[Any] = []
    results: dict[int, ResultRow] = {}
    for command in (
        DropCommand(2**63, stake=100, who="ann"),
        DropCommand(7, x=0.25, who="ben", practice=True),
        DropCommand(8, tag=Tag("Ada", "#57c7ff")),
        DropCommand(9, aim=0.125, stake=7, who="ann"),
    ):
        room.drop(command)
        rows.append(room.fact_of(command, room.drops - 1))
        for _ in range(30):
            room.step(watched=False)
            results |= {result.ball: result for result in room.take_results()}
    assert 0 < len(results) < len(rows), "some have landed, some not"
    entries = [room.format.entry(row, results.get(row.ball), room.world.tick) for row in rows]
    return finished(room, entries)


def row_of(room: TouchingRoom, pending: Pending) -> InputRow:
    """The ledger's row of an input that has entered."""
    assert pending.number is not None
    new = room.format.new(1, pending)
    return InputRow(new.room, pending.number, new.tick, new.data, new.who)


def of_inputs(room: TouchingRoom, told: Sequence[dict[str, Any] | DropCommand]) -> Log:
    """Inputs to a room of touching balls, five ticks apart."""
    rows: list[InputRow] = []
    for what in told:
        if isinstance(what, DropCommand):
            pending = room.plan_drop(what)
        else:
            pending = room.plan_change(msgspec.convert(what, Change))
        pending.durable = True
        room.enter()
        rows.append(row_of(room, pending))
        for _ in range(5):
            room.step(watched=False)
    return finished(room, [room.format.entry(row, None, room.world.tick) for row in rows])


def of_scene() -> Log:
    """A sandbox whose inputs, settings and scene have floats with whole values."""
    scene = Scene.of(SCENE, tick_rate=TICKS, max_balls=100)
    room = TouchingRoom("box", scene, tick_rate=TICKS, max_balls=100)
    return of_inputs(
        room,
        [
            {"type": "add", "x": 0, "y": 1.0, "vx": 3.0, "radius": 0.1, "density": 80},
            {"type": "kick", "ball": 0, "vy": -2.0, "omega": 1e-7},
            {"type": "settings", "gravity": 5.0, "substeps": 6, "friction": 1.0},
            {"type": "reset", "scene": {**SCENE, "width": 4.0, "gravity": 3.0, "seed": 2**60}},
            {"type": "drag", "ball": 1, "x": -0.0, "y": 1.0},
        ],
    )


def of_board() -> Log:
    """Drops in a room of touching balls, with their players."""
    board = Board.preset("triangle-8")
    room = TouchingRoom("table", board, tick_rate=TICKS, max_balls=100)
    return of_inputs(
        room,
        [DropCommand(1, who="ann"), DropCommand(2, x=0.0), {"type": "kick", "ball": 0, "vx": 1.0}],
    )


def finished(room: Room, entries: list[dict[str, Any]]) -> Log:
    """Complete a log of these entries with its digest."""
    digest = roomlog.LogDigest(roomlog.head(room))
    digest.add(entries)
    return {**roomlog.head(room), room.format.name: entries, "digest": digest.hex()}


LOGS = {"drops": of_drops, "scene": of_scene, "board": of_board}
