"""Drops of independent balls as rows of the ledger and as entries of a log."""

from collections.abc import Mapping
from typing import Any, Final

from plinko.app.protocol.visitors import TAG_FIELDS, parse_tag
from plinko.app.rooms.input_format import InputFormat, check_known
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.records import DropRow, ResultRow
from plinko.app.rooms.stakes import parse_stake, parse_who
from plinko.engine.drops.verify import Verification
from plinko.engine.errors import RecordError
from plinko.engine.json_text import JsonObject
from plinko.engine.seeding import parse_seed

ENTRY: Final = ("ball", "tick", "seed", "result")
"""The required fields of a log's drop."""

ENTRY_OPTIONAL: Final = ("x", "aim", "stake", "who", "practice", *TAG_FIELDS)
"""Further fields that it may have."""

RESULT: Final = tuple(name for name in ResultRow.__slots__ if name not in ("room", "ball"))
"""The fields of its result."""


class DropFormat(InputFormat[DropRow]):
    """Each drop has its own result, which depends only on its seed and start."""

    name = "drops"
    needed = (
        "version", "board", "board_digest", "mode", "solver", "tick_rate", "physics_version",
        "tick", "drops", "world_digest", "digest",
    )  # fmt: skip
    has_results = True

    def entry(self, row: DropRow, result: ResultRow | None, tick: int) -> dict[str, object]:
        """One drop of a log that ends at `tick`; a ball that landed later has no result yet."""
        ended = None
        if result is not None and result.tick <= tick:
            ended = _fields(result)
        return {
            "ball": row.ball,
            "tick": row.tick,
            "seed": str(row.seed),
            "x": row.x,
            **({} if row.aim is None else {"aim": row.aim}),
            "stake": row.stake,
            "who": row.who,
            **({"practice": True} if row.practice else {}),
            **row.tag.fields,
            "result": ended,
        }

    def check(self, where: str, number: int, entry: object) -> None:
        if not isinstance(entry, Mapping):
            raise RecordError(f"{where} is not an object", field=where)
        for name in ENTRY:
            if name not in entry:
                raise RecordError(f"{where} lacks {name!r}", field=f"{where}.{name}")
        check_known(entry, (*ENTRY, *ENTRY_OPTIONAL), where)
        if entry["ball"] != number:
            raise RecordError(
                f"{where}.ball is {entry['ball']!r}: balls are numbered from 0, none left out",
                field=f"{where}.ball",
            )
        result = entry["result"]
        if result is not None and not (
            isinstance(result, Mapping) and all(name in result for name in RESULT)
        ):
            raise RecordError(
                f"{where}.result is neither null nor an object with {', '.join(RESULT)}",
                field=f"{where}.result",
            )
        check_known(result or {}, RESULT, f"{where}.result")

    def command(self, entry: JsonObject) -> DropCommand:
        """The command of an entry; raises SeedError, InvalidValueError."""
        stake, who = parse_stake(entry.get("stake")), parse_who(entry.get("who"))
        seed, practice = parse_seed(entry["seed"]), entry.get("practice", False) is True
        x, aim = entry.get("x"), entry.get("aim")
        tag = parse_tag(*map(entry.get, TAG_FIELDS))
        return DropCommand(seed, x, stake, who, aim, practice=practice, tag=tag)

    def compare(
        self, where: str, entry: JsonObject, result: ResultRow | None
    ) -> Verification | None:
        """The first difference between a replayed result and the entry's.

        A result without a digest belongs to a drop that was given up. No replay can confirm it, so
        only its bin, score and payout are checked.
        """
        said, where = entry["result"], f"{where}.result"
        if said is not None and not said["digest"] and result is None:
            return _differs(where, said, entry.get("stake") or 0)
        actual = None if result is None else _fields(result)
        if said is None or actual is None:
            return None if said is actual else Verification(False, where, said, actual)
        for name, value in actual.items():
            if said[name] != value:
                return Verification(False, f"{where}.{name}", said[name], value)
        return None


def _fields(result: ResultRow) -> dict[str, Any]:
    return {name: getattr(result, name) for name in RESULT}


def _differs(where: str, said: JsonObject, stake: int) -> Verification | None:
    """The first field in which the result of a drop that was given up does not pay its stake."""
    for name, value in (("bin", None), ("score", 1.0), ("payout", stake)):
        if said[name] != value:
            return Verification(False, f"{where}.{name}", said[name], value)
    return None
