"""A room's log: its inputs and what came of them, enough to replay all of it. Pure.

`plinko verify` and whoever else reads one replays the drops at their ticks and compares every
result, and at the end the whole world, to the last bit.
"""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

import msgspec

from app.errors import AppError
from app.protocol.messages import Landed
from app.rooms.independent import MODE, SOLVER, DropCommand, Room
from app.rooms.records import DropRow, ResultRow
from app.rooms.stakes import parse_stake
from app.rooms.touching import log as arena_log
from engine import PHYSICS_VERSION
from engine.drops.verify import Verification, board_of
from engine.errors import EngineError, RecordError
from engine.seeding import parse_seed

KIND: Final = "plinko-room"
VERSION: Final = 1

_RESULT: Final = ("tick", "bin", "score", "t", "x_end", "digest", "unsettled")
_NEEDED: Final = (
    "version", "board", "board_digest", "mode", "solver", "tick_rate", "physics_version",
    "tick", "drops", "world_digest", "digest",
)  # fmt: skip
_NO_LIMIT: Final = 1 << 62  # balls; what the room once took, its replay takes


def head(room: Room) -> dict[str, Any]:
    """What comes before the drops in the log of a room as it is now."""
    return {
        "kind": KIND,
        "version": VERSION,
        "room": room.id,
        "board": room.board.preset_name or room.board.to_dict(),
        "board_digest": room.board.digest,
        "mode": MODE,
        "solver": SOLVER,
        "tick_rate": room.tick_rate,
        "physics_version": PHYSICS_VERSION,
        "tick": room.world.tick,
        "world_digest": room.world.digest(),
    }


def entry(drop: DropRow, result: ResultRow | None, tick: int) -> dict[str, Any]:
    """One drop of a log that ends at `tick`: what landed later has no result yet."""
    ended = None
    if result is not None and result.tick <= tick:
        ended = {name: getattr(result, name) for name in _RESULT} | {"payout": result.payout}
    return {
        "ball": drop.ball,
        "tick": drop.tick,
        "seed": str(drop.seed),
        "x": drop.x,
        "stake": drop.stake,
        "who": drop.who,
        "result": ended,
    }


class LogDigest:
    """SHA-256 over a log's world and, in order, each drop's result."""

    def __init__(self, world_digest: str) -> None:
        self._hash = hashlib.sha256(world_digest.encode())

    def add(self, entries: Iterable[Mapping[str, Any]]) -> None:
        """Take in the next drops."""
        for each in entries:
            result = each["result"]
            self._hash.update((result["digest"] if result else "-").encode() + b"\n")

    def hex(self) -> str:
        """64 hexadecimal digits."""
        return self._hash.hexdigest()


def is_log(record: Mapping[str, Any]) -> bool:
    """Whether a JSON object is a room's log, and not a drop's record."""
    return record.get("kind") == KIND


def verify_log(log: Mapping[str, Any]) -> Verification:
    """Replay the room that `log` describes and compare all that it claims.

    `expected` is what the log says, `actual` what comes out, `field` the first place where they
    differ. Raises RecordError, naming the field, for a log that lacks one or cannot be replayed.
    """
    if log.get("mode", MODE) != MODE:
        return arena_log.verify(log)
    for name in _NEEDED:
        if name not in log:
            raise RecordError(f"the log lacks {name!r}", field=name)
    board = board_of(log)
    mine = {
        "version": VERSION,
        "board_digest": board.digest,
        "mode": MODE,
        "solver": SOLVER,
        "physics_version": PHYSICS_VERSION,
    }
    for name, value in mine.items():
        if log[name] != value:
            return Verification(False, name, log[name], value)
    drops = _drops(log["drops"])
    tick_rate, last = _whole(log, "tick_rate", 1), _whole(log, "tick", 0)
    room = Room(str(log.get("room", "")), board, tick_rate=tick_rate, max_balls=_NO_LIMIT)
    results = _replay(room, drops, last)
    return _compare(log, drops, room, results)


def _drops(value: object) -> list[Mapping[str, Any]]:
    if not isinstance(value, Sequence) or isinstance(value, str):
        raise RecordError("drops is not a list", field="drops")
    for number, drop in enumerate(value):
        where = f"drops[{number}]"
        if not isinstance(drop, Mapping):
            raise RecordError(f"{where} is not an object", field=where)
        for name in ("ball", "tick", "seed", "result"):
            if name not in drop:
                raise RecordError(f"{where} lacks {name!r}", field=f"{where}.{name}")
        if drop["ball"] != number:
            raise RecordError(
                f"{where}.ball is {drop['ball']!r}: balls are numbered from 0, none left out",
                field=f"{where}.ball",
            )
        result = drop["result"]
        if result is not None and not (
            isinstance(result, Mapping) and all(name in result for name in (*_RESULT, "payout"))
        ):
            raise RecordError(
                f"{where}.result is neither null nor an object with {', '.join(_RESULT)}",
                field=f"{where}.result",
            )
    return list(value)


def _whole(values: Mapping[str, Any], name: str, least: int, where: str = "") -> int:
    value = values[name]
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise RecordError(
            f"{where}{name} {value!r} is not a whole number from {least} on", field=where + name
        )
    return value


def _replay(room: Room, drops: Sequence[Mapping[str, Any]], last: int) -> dict[int, Landed]:
    """Put the drops in at their ticks, go on to tick `last`; returns the landings by ball."""
    results: dict[int, Landed] = {}
    for number, drop in enumerate(drops):
        where = f"drops[{number}]."
        tick = _whole(drop, "tick", room.world.tick, where)
        if tick > last:
            raise RecordError(f"{where}tick {tick} is after the log's tick {last}", field="tick")
        _advance(room, tick, results)
        try:
            stake = parse_stake(drop.get("stake"))
            room.drop(DropCommand(parse_seed(drop["seed"]), drop.get("x"), stake))
        except (EngineError, AppError, TypeError) as error:
            raise RecordError(f"drops[{number}]: {error}", field=f"drops[{number}]") from error
    _advance(room, last, results)
    return results


def _advance(room: Room, tick: int, results: dict[int, Landed]) -> None:
    while room.world.tick < tick:
        for event in room.step(watched=False):
            if isinstance(event, Landed):
                results[event.ball] = event


def _compare(
    log: Mapping[str, Any],
    drops: Sequence[Mapping[str, Any]],
    room: Room,
    results: Mapping[int, Landed],
) -> Verification:
    for number, drop in enumerate(drops):
        said, landed = drop["result"], results.get(number)
        where = f"drops[{number}].result"
        if said is None or landed is None:
            if said is not None or landed is not None:
                actual = None if landed is None else msgspec.to_builtins(landed)
                return Verification(False, where, said, actual)
            continue
        actual = {name: getattr(landed, name) for name in _RESULT} | {"payout": landed.paid}
        for name, value in actual.items():
            if said[name] != value:
                return Verification(False, f"{where}.{name}", said[name], value)
    world = room.world.digest()
    if log["world_digest"] != world:
        return Verification(False, "world_digest", log["world_digest"], world)
    digest = LogDigest(world)
    digest.add(drops)
    if log["digest"] != digest.hex():
        return Verification(False, "digest", log["digest"], digest.hex())
    return Verification(True)
