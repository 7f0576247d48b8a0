"""Verifies a drop's record: recomputes the drop and compares field by field."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from plinko.engine.board.model import Board
from plinko.engine.constants import PHYSICS_VERSION
from plinko.engine.drops.drop import Drop, make_drop
from plinko.engine.errors import EngineError, RecordError
from plinko.engine.parameters import Exact, Stepped, make_solver
from plinko.engine.seeding import parse_seed

FIELDS = (
    "board_digest",
    "physics_version",
    "bin",
    "score",
    "label",
    "duration",
    "x_end",
    "impacts",
    "digest",
)
"""Fields that a record claims, in the order of comparison; the others say what to simulate."""

HOW_SURE = ("amplification", "x_error", "certain")
"""Optional claims about the certainty of the bin."""

_ASKED = ("board", "seed", "x", "aim", "solver", "dt", "substeps", "correction")


@dataclass(frozen=True, slots=True)
class Verification:
    """The result for a record: `ok`, or the first field that differs, with both values."""

    ok: bool
    field: str | None = None
    expected: Any = None
    actual: Any = None


def verify(record: Mapping[str, Any]) -> Verification:
    """Recompute the drop that `record` describes, and compare every field of the record.

    `expected` is the record's value, `actual` the recomputed one. Raises RecordError naming the
    field for a record with a missing or unknown field, or one that cannot be simulated.
    """
    if not isinstance(record, Mapping):
        raise RecordError("the record must be a JSON object", field="")
    for name in ("board", "board_digest", "seed", "solver", "physics_version", "digest"):
        if name not in record:
            raise RecordError(f"the record lacks {name!r}", field=name)
    _check_known(record)
    board = board_of(record)
    if record["board_digest"] != board.digest:
        return Verification(False, "board_digest", record["board_digest"], board.digest)
    if record["physics_version"] != PHYSICS_VERSION:
        return Verification(False, "physics_version", record["physics_version"], PHYSICS_VERSION)
    sure = any(record.get(name) is not None for name in HOW_SURE)
    actual = replay(record, board).to_dict(certainty=sure)
    for name in (*FIELDS, *(HOW_SURE if sure else ())):
        if name not in record:
            continue
        difference = _difference(name, record[name], actual.get(name))
        if difference is not None:
            return difference
    return Verification(True)


def _check_known(record: Mapping[str, Any]) -> None:
    """Raise RecordError for a field that would be ignored: unknown, or of the other solver."""
    for name in record:
        if name not in (*_ASKED, *FIELDS, *HOW_SURE):
            known = ", ".join((*_ASKED, *FIELDS, *HOW_SURE))
            raise RecordError(
                f"the record has an unknown field {name!r}: the fields are {known}", field=name
            )
    if record["solver"] == Exact.name:
        for name in Stepped().fields():
            if record.get(name) is not None:
                raise RecordError(
                    f"{name} belongs to the stepped solver: exact has no time step", field=name
                )


def board_of(record: Mapping[str, Any]) -> Board:
    """The board of a record: a preset by name, or a whole board in JSON form."""
    board = record["board"]
    try:
        return Board.preset(board) if isinstance(board, str) else Board.from_json(board)
    except (EngineError, TypeError) as error:
        raise RecordError(f"board: {error}", field="board") from error


def replay(record: Mapping[str, Any], board: Board) -> Drop:
    try:
        seed = None if record["seed"] is None else parse_seed(record["seed"])
        how = {name: record[name] for name in Stepped().fields() if name in record}
        name = record["solver"]
        solver = Stepped(**how) if name == Stepped.name else make_solver(name)
        return make_drop(board, seed, record.get("x"), solver, record.get("aim"))
    except EngineError as error:
        raise RecordError(str(error), field=error.field) from error


def _difference(name: str, expected: Any, actual: Any) -> Verification | None:
    """The result if two values differ, else None; within impacts it names the first such row."""
    if name == "impacts" and isinstance(expected, list) and len(expected) == len(actual):
        for i, (old, new) in enumerate(zip(expected, actual, strict=True)):
            if old != new:
                return Verification(False, f"impacts[{i}]", old, new)
        return None
    if name == "impacts" and isinstance(expected, list):
        return Verification(False, "impacts", f"{len(expected)} impacts", f"{len(actual)} impacts")
    return None if expected == actual else Verification(False, name, expected, actual)
