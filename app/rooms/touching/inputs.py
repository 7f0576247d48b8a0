"""What is done to a room whose balls touch each other, checked: as it is kept, logged, replayed.

The order of the fields is that of the JSON in the ledger. A field that is left out was not asked
for. Units are those of `app.rooms.touching.values`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import msgspec

from app.errors import InvalidValueError
from app.rooms.input_format import InputFormat, check_known
from app.rooms.pending import PendingInput
from app.rooms.records import InputRow, ResultRow
from app.rooms.stakes import parse_who
from app.rooms.touching.scene import as_kept
from engine import Board
from engine.drops.start import start_of
from engine.errors import RecordError
from engine.json_text import JsonObject
from engine.seeding import parse_seed

_Number = float | msgspec.UnsetType


class _Input(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An input; its tag is its `type`."""

    begins_anew: ClassVar[bool] = False  # everyone who watches starts over


class Drop(_Input, frozen=True, kw_only=True, tag="drop"):
    """Drop a ball as players do; `x` where the player chose the start, or `aim` its middle."""

    seed: str
    x: float | None
    aim: _Number = msgspec.UNSET

    def start(self, board: Board) -> float:
        """Where its ball starts, x in m."""
        aim = None if self.aim is msgspec.UNSET else self.aim
        return start_of(board, parse_seed(self.seed), self.x, aim)


class Add(_Input, frozen=True, kw_only=True, tag="add"):
    """Put in a ball, at rest or thrown."""

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
    """Change a ball's velocity by so much."""

    ball: int
    vx: _Number = msgspec.UNSET
    vy: _Number = msgspec.UNSET
    omega: _Number = msgspec.UNSET


class Drag(_Input, frozen=True, kw_only=True, tag="drag"):
    """Hold a ball and draw it to this place."""

    ball: int
    x: float
    y: float


class Release(_Input, frozen=True, kw_only=True, tag="release"):
    """Let go of a ball."""

    ball: int


class Remove(_Input, frozen=True, kw_only=True, tag="remove"):
    """Take a ball out."""

    ball: int


class Clear(_Input, frozen=True, kw_only=True, tag="clear"):
    """Take all balls out."""


class Edit(_Input, frozen=True, kw_only=True, tag="edit"):
    """Make a ball another one."""

    ball: int
    radius: _Number = msgspec.UNSET
    density: _Number = msgspec.UNSET
    restitution: _Number = msgspec.UNSET
    friction: _Number = msgspec.UNSET


class Configure(_Input, frozen=True, kw_only=True, tag="settings"):
    """Set what holds for the room; density, restitution and friction for every ball in it."""

    gravity: _Number = msgspec.UNSET
    drag: _Number = msgspec.UNSET
    damping: _Number = msgspec.UNSET
    correction: _Number = msgspec.UNSET
    dt: _Number = msgspec.UNSET
    substeps: int | msgspec.UnsetType = msgspec.UNSET
    density: _Number = msgspec.UNSET
    restitution: _Number = msgspec.UNSET
    friction: _Number = msgspec.UNSET


class Pause(_Input, frozen=True, kw_only=True, tag="pause"):
    """Stop the clock, or let it run."""

    paused: bool


class Step(_Input, frozen=True, kw_only=True, tag="step"):
    """One tick of a clock that is stopped."""


class Reset(_Input, frozen=True, kw_only=True, tag="reset"):
    """Begin anew, as another scene where one is given."""

    begins_anew: ClassVar[bool] = True
    scene: dict[str, object] | msgspec.UnsetType = msgspec.UNSET


TouchingInput = (
    Drop | Add | Kick | Drag | Release | Remove | Clear | Edit | Configure | Pause | Step | Reset
)


def given(values: msgspec.Struct, *but: str) -> dict[str, float]:
    """The fields of an input that were asked for, without those named in `but`."""
    fields = msgspec.structs.asdict(values)
    return {
        name: value
        for name, value in fields.items()
        if value is not msgspec.UNSET and name not in but
    }


@dataclass(frozen=True, slots=True)
class TouchingCommand:
    """An input and the mark of the player it came from, if any."""

    input: TouchingInput
    who: str | None = None


class ChangeFormat(InputFormat[TouchingCommand, InputRow]):
    """Such a room follows from all its inputs, so its log needs no results."""

    name = "inputs"
    needed = (
        "version", "board_digest", "mode", "solver", "tick_rate", "physics_version", "tick",
        "inputs", "world_digest", "digest",
    )  # fmt: skip
    optional = ("kind", "room", "board", "scene")
    replayed = ".input"

    def row(self, run: int, pending: PendingInput[TouchingCommand]) -> InputRow:
        data = msgspec.json.encode(pending.command.input).decode()
        who = pending.command.who
        return InputRow(run, pending.number, pending.tick, data, who, pending.again)

    def entry(self, row: InputRow, result: ResultRow | None, tick: int) -> dict[str, object]:
        return {"tick": row.tick, "who": row.who, "input": msgspec.json.decode(row.data)}

    def check(self, where: str, number: int, entry: object) -> None:
        """Raise RecordError unless the entry has all that an input needs."""
        if not isinstance(entry, Mapping) or not {"tick", "input"} <= entry.keys():
            raise RecordError(f"{where} is not an object with tick and input", field=where)
        if not isinstance(entry["input"], Mapping) or "type" not in entry["input"]:
            raise RecordError(f"{where}.input is not an object with a type", field=where)
        check_known(entry, ("tick", "who", "input"), where)
        try:
            parse_who(entry.get("who"))
        except InvalidValueError as error:
            raise RecordError(f"{where}.{error}", field=f"{where}.who") from error

    def first_line(self, entry: JsonObject) -> bytes:
        """The input with its tick."""
        asked = msgspec.to_builtins(self.input(entry))
        return msgspec.json.encode([entry["tick"], asked], order="sorted")

    def input(self, entry: JsonObject) -> TouchingInput:
        """The input that an entry tells of; raises RecordError."""
        try:
            found: TouchingInput = msgspec.convert(entry["input"], TouchingInput)
        except msgspec.ValidationError as error:
            raise RecordError(str(error), field="input") from error
        if isinstance(found, Reset) and isinstance(found.scene, dict):
            return Reset(scene=as_kept(found.scene))
        return found
