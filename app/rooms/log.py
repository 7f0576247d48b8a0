"""A room's log: its inputs and results, enough to replay the room. Pure.

`plinko verify` and other readers replay the inputs at their ticks. They compare every result in the
log and, at the end, the whole world, to the last bit. The log's digest also covers what a replay
cannot check, such as whose a drop was, except tags (the names and colours shown to spectators). An
unknown field is refused, because no check would cover it.
"""

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Final

from plinko.app.protocol.visitors import TAG_FIELDS
from plinko.app.rooms.canonical import canonical
from plinko.app.rooms.input_format import AnyFormat, check_known
from plinko.app.rooms.kinds import INDEPENDENT, INTERACTING, NO_LIMIT, SCENE, format_of, make_room
from plinko.app.rooms.records import ResultRow
from plinko.app.rooms.room import Ground, Room
from plinko.app.rooms.touching.scene import Scene
from plinko.engine import PHYSICS_VERSION
from plinko.engine.drops.verify import Verification, board_of
from plinko.engine.errors import PlinkoError, RecordError
from plinko.engine.json_text import JsonObject

KIND: Final = "plinko-room"
VERSION: Final = 2


def head(room: Room) -> dict[str, Any]:
    """The fields before the inputs, in the log of a room in its current state."""
    return {
        "kind": KIND,
        "version": VERSION,
        "room": room.id,
        **room.ground_fields(),
        "board_digest": room.origin.digest,
        "mode": room.logged_mode,
        "solver": room.solver,
        "tick_rate": room.tick_rate,
        "physics_version": PHYSICS_VERSION,
        "tick": room.log_tick,
        "world_digest": room.log_world(),
    }


def lines(entries: Iterable[JsonObject]) -> bytes:
    """The bytes of entries that a log's digest covers: canonical JSON without tags."""
    return b"".join(canonical(_covered(each)) + b"\n" for each in entries)


def _covered(entry: JsonObject) -> JsonObject:
    if entry.keys().isdisjoint(TAG_FIELDS):
        return entry
    return {name: value for name, value in entry.items() if name not in TAG_FIELDS}


class LogDigest:
    """SHA-256 over a log's lines of canonical JSON: its head, then each entry without its tag."""

    def __init__(self, head: JsonObject) -> None:
        self._hash = hashlib.sha256()
        self.add([head])

    def add(self, entries: Iterable[JsonObject]) -> None:
        self.add_lines(lines(entries))

    def add_lines(self, text: bytes) -> None:
        """Add the next entries, already converted by `lines`."""
        self._hash.update(text)

    def hex(self) -> str:
        return self._hash.hexdigest()


def is_log(record: JsonObject) -> bool:
    """Whether a JSON object is a room's log, rather than a drop's record."""
    return record.get("kind") == KIND


def verify_log(
    log: JsonObject, progress: Callable[[int], None] = lambda tick: None
) -> Verification:
    """Replay the room that `log` describes and compare everything that the log claims.

    In the returned verification `field` is the first place that differs, `expected` the log's value
    and `actual` the replay's. `progress` is called with each replayed tick, and may raise to stop.
    Raises RecordError, naming the field, if the log lacks a field or cannot be replayed.
    """
    independent = log.get("mode", INDEPENDENT) == INDEPENDENT
    inputs = format_of(INDEPENDENT if independent else INTERACTING)
    for name in inputs.needed:
        if name not in log:
            raise RecordError(f"the log lacks {name!r}", field=name)
    check_known(log, (*inputs.needed, *inputs.optional), "the log")
    room = _room_of(log, independent)
    mine = {
        "version": VERSION,
        "board_digest": room.origin.digest,
        "mode": room.mode,
        "solver": room.solver,
        "physics_version": PHYSICS_VERSION,
    }
    for name, value in mine.items():
        if log[name] != value:
            return Verification(False, name, log[name], value)
    entries = _entries(inputs, log[inputs.name])
    results = _replay(room, entries, _whole(log, "tick", 0), progress)
    return _compare(log, entries, room, results)


def _room_of(log: JsonObject, independent: bool) -> Room:
    tick_rate = _whole(log, "tick_rate", 1)
    ground: Ground
    if independent or log.get("scene") is None:
        if "board" not in log:
            raise RecordError("the log lacks 'board'", field="board")
        ground, mode = board_of(log), INDEPENDENT if independent else INTERACTING
    elif log.get("board") is not None:
        raise RecordError("a log has either a board or a scene", field="board")
    else:
        ground, mode = _scene_of(log["scene"], tick_rate), SCENE
    room_id = str(log.get("room", ""))
    return make_room(room_id, ground, mode, tick_rate=tick_rate, limits=NO_LIMIT)


def _scene_of(values: object, tick_rate: int) -> Scene:
    try:
        return Scene.of(values, tick_rate=tick_rate, max_balls=NO_LIMIT.touching)
    except PlinkoError as error:
        raise RecordError(f"scene: {error}", field="scene") from error


def _entries(inputs: AnyFormat, value: object) -> list[JsonObject]:
    if not isinstance(value, Sequence) or isinstance(value, str):
        raise RecordError(f"{inputs.name} is not a list", field=inputs.name)
    for number, entry in enumerate(value):
        inputs.check(f"{inputs.name}[{number}]", number, entry)
    return list(value)


def _whole(values: JsonObject, name: str, least: int, where: str = "") -> int:
    value = values[name]
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise RecordError(
            f"{where}{name} {value!r} is not a whole number from {least} on", field=where + name
        )
    return value


def _replay(
    room: Room, entries: Sequence[JsonObject], last: int, progress: Callable[[int], None]
) -> dict[int, ResultRow]:
    """Carry out the inputs at their ticks and advance to `last`; returns the results by ball."""
    results: dict[int, ResultRow] = {}
    for number, entry in enumerate(entries):
        where = f"{room.format.name}[{number}]"
        tick = _whole(entry, "tick", room.world.tick, f"{where}.")
        if tick > last:
            raise RecordError(f"{where}.tick {tick} is after the log's tick {last}", field="tick")
        _advance(room, tick, results, progress)
        try:
            room.replay(entry)
        except (PlinkoError, TypeError) as error:
            where += room.format.replayed
            raise RecordError(f"{where}: {error}", field=where) from error
    _advance(room, last, results, progress)
    return results


def _advance(
    room: Room, tick: int, results: dict[int, ResultRow], progress: Callable[[int], None]
) -> None:
    """Advance to this tick. A table goes there at once; touching balls go tick by tick."""
    alone = room.kind == INDEPENDENT
    while room.world.tick < tick:
        progress(room.world.tick)
        room.advance(tick if alone else room.world.tick + 1)
        results.update((result.ball, result) for result in room.take_results())


def _compare(
    log: JsonObject,
    entries: Sequence[JsonObject],
    room: Room,
    results: Mapping[int, ResultRow],
) -> Verification:
    inputs = room.format
    for number, entry in enumerate(entries):
        where = f"{inputs.name}[{number}]"
        difference = inputs.compare(where, entry, results.get(number))
        if difference is not None:
            return difference
    world = room.world.digest
    if log["world_digest"] != world:
        return Verification(False, "world_digest", log["world_digest"], world)
    digest = _digest(log, entries, inputs)
    if log["digest"] != digest:
        return Verification(False, "digest", log["digest"], digest)
    return Verification(True)


def _digest(log: JsonObject, entries: Sequence[JsonObject], inputs: AnyFormat) -> str:
    rest = (inputs.name, "digest")
    digest = LogDigest({name: value for name, value in log.items() if name not in rest})
    digest.add(entries)
    return digest.hex()
