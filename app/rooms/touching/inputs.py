"""The validated inputs of a room of touching balls, as the ledger and the log write them.

touching_messages.py says what each of them does. The fields are in the order of the ledger's JSON.
UNSET stands for a field that the client did not give. Units are those of
`plinko.app.rooms.touching.values`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import msgspec

from plinko.app.errors import InvalidValueError
from plinko.app.rooms.input_format import InputFormat, check_known
from plinko.app.rooms.keys import IdempotencyKey
from plinko.app.rooms.pending import PendingInput
from plinko.app.rooms.records import InputRow, NewInput, ResultRow
from plinko.app.rooms.stakes import parse_who
from plinko.app.rooms.touching.scene import as_kept
from plinko.engine import Board
from plinko.engine.drops.start import start_of
from plinko.engine.errors import RecordError
from plinko.engine.json_text import JsonObject
from plinko.engine.seeding import parse_seed

_Number = float | msgspec.UnsetType


class _Input(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The base of all inputs; the msgspec tag is the JSON field `type`."""

    restarts: ClassVar[bool] = False  # whether every client needs a new hello


class Drop(_Input, frozen=True, kw_only=True, tag="drop"):
    """Drop a ball; `x` and `aim` in m, as in `DropCommand`."""

    seed: str
    x: float | None
    aim: _Number = msgspec.UNSET

    def start(self, board: Board) -> float:
        """The x at which its ball starts, in m."""
        aim = None if self.aim is msgspec.UNSET else self.aim
        return start_of(board, parse_seed(self.seed), self.x, aim)


class Add(_Input, frozen=True, kw_only=True, tag="add"):
    density: float
    restitution: float
    friction: float
    x: float
    y: float
    vx: _Number = msgspec.UNSET
    vy: _Number = msgspec.UNSET
    omega: _Number = msgspec.UNSET
    radius: float


class Kick(_Input, frozen=True, kw_only=True, tag="kick"):
    ball: int
    vx: _Number = msgspec.UNSET
    vy: _Number = msgspec.UNSET
    omega: _Number = msgspec.UNSET


class Drag(_Input, frozen=True, kw_only=True, tag="drag"):
    ball: int
    x: float
    y: float


class Release(_Input, frozen=True, kw_only=True, tag="release"):
    ball: int


class Remove(_Input, frozen=True, kw_only=True, tag="remove"):
    ball: int


class Clear(_Input, frozen=True, kw_only=True, tag="clear"):
    """Remove all balls."""


class Edit(_Input, frozen=True, kw_only=True, tag="edit"):
    ball: int
    radius: _Number = msgspec.UNSET
    density: _Number = msgspec.UNSET
    restitution: _Number = msgspec.UNSET
    friction: _Number = msgspec.UNSET


class Configure(_Input, frozen=True, kw_only=True, tag="settings"):
    gravity: _Number = msgspec.UNSET
    gravity_x: _Number = msgspec.UNSET
    drag: _Number = msgspec.UNSET
    damping: _Number = msgspec.UNSET
    rolling: _Number = msgspec.UNSET
    max_speed: _Number = msgspec.UNSET
    correction: _Number = msgspec.UNSET
    dt: _Number = msgspec.UNSET
    substeps: int | msgspec.UnsetType = msgspec.UNSET
    projection: int | msgspec.UnsetType = msgspec.UNSET
    cell: _Number = msgspec.UNSET
    density: _Number = msgspec.UNSET
    restitution: _Number = msgspec.UNSET
    friction: _Number = msgspec.UNSET


class Pause(_Input, frozen=True, kw_only=True, tag="pause"):
    paused: bool


class Step(_Input, frozen=True, kw_only=True, tag="step"):
    """Run one tick while the clock is stopped."""


class Reset(_Input, frozen=True, kw_only=True, tag="reset"):
    restarts: ClassVar[bool] = True
    scene: dict[str, object] | msgspec.UnsetType = msgspec.UNSET


TouchingInput = (
    Drop | Add | Kick | Drag | Release | Remove | Clear | Edit | Configure | Pause | Step | Reset
)


def given(values: msgspec.Struct, *but: str) -> dict[str, float]:
    """The fields of an input that are set, except those named in `but`."""
    fields = msgspec.structs.asdict(values)
    return {
        name: value
        for name, value in fields.items()
        if value is not msgspec.UNSET and name not in but
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
        if isinstance(found, Reset) and isinstance(found.scene, dict):
            return Reset(scene=as_kept(found.scene))
        return found
