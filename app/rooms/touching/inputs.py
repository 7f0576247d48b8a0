"""The validated inputs of a room of touching balls, as the ledger and the log write them.

A change is the client's message (touching_messages.py) without its `ref`, and with numbers that
`checks` has validated. Units are those of `plinko.app.rooms.touching.values`.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import msgspec

from plinko.app.errors import InvalidValueError
from plinko.app.protocol import touching_messages as wire
from plinko.app.rooms.input_format import InputFormat, check_known
from plinko.app.rooms.keys import IdempotencyKey
from plinko.app.rooms.pending import PendingInput
from plinko.app.rooms.records import InputRow, NewInput, ResultRow
from plinko.app.rooms.stakes import parse_who
from plinko.app.rooms.touching import values
from plinko.app.rooms.touching.scene import as_kept
from plinko.engine import Board
from plinko.engine.drops.start import start_of
from plinko.engine.errors import RecordError
from plinko.engine.json_text import JsonObject
from plinko.engine.seeding import parse_seed


class Drop(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="drop"):
    """Drop a ball; `x` and `aim` in m, as in `DropCommand`."""

    seed: str
    x: float | None
    aim: float | msgspec.UnsetType = msgspec.UNSET

    def start(self, board: Board) -> float:
        """The x at which its ball starts, in m."""
        aim = None if self.aim is msgspec.UNSET else self.aim
        return start_of(board, parse_seed(self.seed), self.x, aim)


TouchingInput = Drop | wire.Change


def given(asked: TouchingInput, *but: str) -> dict[str, float]:
    """The fields of an input that are set, except `ref` and those named in `but`."""
    fields = msgspec.structs.asdict(asked)
    return {
        name: value
        for name, value in fields.items()
        if value is not None and name not in ("ref", *but)
    }


@dataclass(frozen=True, slots=True)
class TouchingCommand:
    """An input, and the mark of its player, if any."""

    input: TouchingInput
    who: str | None = None


class ChangeFormat(InputFormat[InputRow]):
    """Inputs without results: replaying all inputs recomputes the whole room."""

    name = "inputs"
    needed = (
        "version", "board_digest", "mode", "solver", "tick_rate", "physics_version", "tick",
        "inputs", "world_digest", "digest",
    )  # fmt: skip
    optional = ("kind", "room", "board", "scene")
    replayed = ".input"

    def new(
        self,
        run: int,
        pending: PendingInput[TouchingCommand],
        key: IdempotencyKey | None = None,
    ) -> NewInput:
        data = msgspec.json.encode(pending.command.input).decode()
        return NewInput(run, pending.tick, data, pending.command.who, key)

    def entry(self, row: InputRow, result: ResultRow | None, tick: int) -> dict[str, object]:
        return {"tick": row.tick, "who": row.who, "input": msgspec.json.decode(row.data)}

    def check(self, where: str, number: int, entry: object) -> None:
        if not isinstance(entry, Mapping) or not {"tick", "input"} <= entry.keys():
            raise RecordError(f"{where} is not an object with tick and input", field=where)
        if not isinstance(entry["input"], Mapping) or "type" not in entry["input"]:
            raise RecordError(f"{where}.input is not an object with a type", field=where)
        check_known(entry, ("tick", "who", "input"), where)
        try:
            parse_who(entry.get("who"))
        except InvalidValueError as error:
            raise RecordError(f"{where}.{error}", field=f"{where}.who") from error

    def input(self, entry: JsonObject) -> TouchingInput:
        """The input in an entry; raises RecordError."""
        try:
            found: TouchingInput = msgspec.convert(entry["input"], TouchingInput)
        except msgspec.ValidationError as error:
            raise RecordError(str(error), field="input") from error
        if isinstance(found, Drop):
            return found
        if found.ref is not None:
            raise RecordError("an input has no `ref`", field="input.ref")
        if isinstance(found, wire.ResetMessage):
            return found if found.scene is None else wire.ResetMessage(scene=as_kept(found.scene))
        numbers = given(found, "ball", "paused")
        checked = {name: values.number_of(value, name) for name, value in numbers.items()}
        return msgspec.structs.replace(found, **checked)
