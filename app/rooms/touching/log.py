"""The log of a room whose balls touch each other: its ground, and all inputs by tick. Pure.

Such a room follows from its inputs alone, so its log needs no results: a replay ends in the same
world, to the last bit, or somebody changed something.
"""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

import msgspec

from app.errors import AppError
from app.rooms.records import InputRow
from app.rooms.touching.room import SOLVER, ArenaRoom
from app.rooms.touching.scene import Scene
from engine import PHYSICS_VERSION
from engine.drops.verify import Verification, board_of
from engine.errors import EngineError, RecordError

VERSION: Final = 1

_NEEDED: Final = (
    "version", "board_digest", "mode", "solver", "tick_rate", "physics_version", "tick", "inputs",
    "world_digest", "digest",
)  # fmt: skip
_NO_LIMIT: Final = 1 << 62  # balls; what the room once took, its replay takes


def head(room: ArenaRoom, kind: str) -> dict[str, Any]:
    """What comes before the inputs in the log of a room as it is now."""
    ground = room.board
    return {
        "kind": kind,
        "version": VERSION,
        "room": room.id,
        "board": None if isinstance(ground, Scene) else ground.preset_name or ground.to_dict(),
        "scene": ground.to_dict() if isinstance(ground, Scene) else None,
        "board_digest": ground.digest,
        "mode": room.mode,
        "solver": SOLVER,
        "tick_rate": room.tick_rate,
        "physics_version": PHYSICS_VERSION,
        "tick": room.world.tick,
        "world_digest": room.world.digest(),
    }


def entry(row: InputRow) -> dict[str, Any]:
    """One input of a log."""
    return {"tick": row.tick, "who": row.who, "input": msgspec.json.decode(row.data)}


class LogDigest:
    """SHA-256 over a log's world and, in order, each input with its tick."""

    def __init__(self, world_digest: str) -> None:
        self._hash = hashlib.sha256(world_digest.encode())

    def add(self, entries: Iterable[Mapping[str, Any]]) -> None:
        """Take in the next inputs."""
        for each in entries:
            line = msgspec.json.encode([each["tick"], each["input"]], order="sorted")
            self._hash.update(line + b"\n")

    def hex(self) -> str:
        """64 hexadecimal digits."""
        return self._hash.hexdigest()


def verify(log: Mapping[str, Any]) -> Verification:
    """Replay the room that `log` describes and compare all that it claims.

    `expected` is what the log says, `actual` what comes out, `field` the first place where they
    differ. Raises RecordError, naming the field, for a log that lacks one or cannot be replayed.
    """
    for name in _NEEDED:
        if name not in log:
            raise RecordError(f"the log lacks {name!r}", field=name)
    tick_rate, last = _whole(log, "tick_rate", 1), _whole(log, "tick", 0)
    if log.get("scene") is not None:
        try:
            ground: Any = Scene.of(log["scene"], tick_rate=tick_rate, max_balls=_NO_LIMIT)
        except (AppError, EngineError) as error:
            raise RecordError(f"scene: {error}", field="scene") from error
    else:
        ground = board_of(log)
    room = ArenaRoom(str(log.get("room", "")), ground, tick_rate=tick_rate, max_balls=_NO_LIMIT)
    mine = {
        "version": VERSION,
        "board_digest": ground.digest,
        "mode": room.mode,
        "solver": SOLVER,
        "physics_version": PHYSICS_VERSION,
    }
    for name, value in mine.items():
        if log[name] != value:
            return Verification(False, name, log[name], value)
    entries = _entries(log["inputs"])
    _replay(room, entries, last)
    world = room.world.digest()
    if log["world_digest"] != world:
        return Verification(False, "world_digest", log["world_digest"], world)
    digest = LogDigest(world)
    digest.add(entries)
    if log["digest"] != digest.hex():
        return Verification(False, "digest", log["digest"], digest.hex())
    return Verification(True)


def _entries(value: object) -> list[Mapping[str, Any]]:
    if not isinstance(value, Sequence) or isinstance(value, str):
        raise RecordError("inputs is not a list", field="inputs")
    for number, each in enumerate(value):
        where = f"inputs[{number}]"
        if not isinstance(each, Mapping) or not {"tick", "input"} <= each.keys():
            raise RecordError(f"{where} is not an object with tick and input", field=where)
        if not isinstance(each["input"], Mapping) or "type" not in each["input"]:
            raise RecordError(f"{where}.input is not an object with a type", field=where)
    return list(value)


def _whole(values: Mapping[str, Any], name: str, least: int, where: str = "") -> int:
    value = values[name]
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise RecordError(
            f"{where}{name} {value!r} is not a whole number from {least} on", field=where + name
        )
    return value


def _replay(room: ArenaRoom, entries: Sequence[Mapping[str, Any]], last: int) -> None:
    """Carry the inputs out at their ticks, and go on to tick `last`."""
    for number, each in enumerate(entries):
        where = f"inputs[{number}]."
        tick = _whole(each, "tick", room.world.tick, where)
        if tick > last:
            raise RecordError(f"{where}tick {tick} is after the log's tick {last}", field="tick")
        while room.world.tick < tick:
            room.step(watched=False)
        try:
            room.replay(dict(each["input"]))
        except (EngineError, AppError, TypeError, KeyError) as error:
            raise RecordError(f"{where}input: {error}", field=f"{where}input") from error
    while room.world.tick < last:
        room.step(watched=False)
