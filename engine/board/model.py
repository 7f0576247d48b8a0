"""`Board`, a valid board: frozen, checked once on construction, with a digest of its content."""

import dataclasses
import functools
import os
from collections.abc import Mapping
from typing import Any

from plinko.engine.board import digest as content
from plinko.engine.board import json_form, making, payouts, presets, values
from plinko.engine.board.checks import playable
from plinko.engine.board.drawing import board_svg
from plinko.engine.board.faults import Faults
from plinko.engine.board.fields import BoardFields
from plinko.engine.board.payouts import Risk
from plinko.engine.notebooks import figure, png


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Board(BoardFields):
    """A valid board. The constructor checks every field, then the board as a whole.

    A part, such as `bins`, may also be a dict in the JSON form, with the same defaults. Boards are
    equal if their digests are. Raises BoardError, whose `faults` list every fault.
    """

    digest: str = dataclasses.field(init=False)
    """SHA-256 of the content, 64 hex digits; `plinko.engine.board.digest` lists the bytes."""

    is_kept: dataclasses.InitVar[bool] = False

    def __post_init__(self, is_kept: bool) -> None:
        """Replace the given values by checked ones, then check the board as a whole.

        Two kinds of boards skip the second check: the presets, which a test checks, and a board
        that `is_kept`, which was checked when it was new.
        """
        faults = Faults()
        for key in json_form.PARTS:
            form = getattr(self, key)
            if isinstance(form, Mapping):
                part = faults.take(json_form.part, key, form, self.width, self.height)
                object.__setattr__(self, key, part)
        faults.end()
        for key, check in values.CHECKS.items():
            object.__setattr__(self, key, faults.take(check, getattr(self, key)))
        faults.end()
        object.__setattr__(self, "digest", content.digest(self))
        if not is_kept and self.preset_name is None:
            playable.check(self)

    def __eq__(self, other: object) -> bool:
        return self.digest == other.digest if isinstance(other, Board) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.digest)

    def __repr__(self) -> str:
        parts = f"{len(self.pegs)} pegs, {len(self.walls)} walls, {self.bins.count} bins"
        return f"<Board {self.name!r}: {parts}, digest {self.digest[:12]}>"

    def _repr_html_(self) -> str:
        return figure(board_svg(self), repr(self))

    def _repr_png_(self) -> bytes | None:
        return png(self)

    @classmethod
    def of(cls, fields: BoardFields) -> "Board":
        """Check `fields` and make a board of them."""
        names = (field.name for field in dataclasses.fields(BoardFields))
        return cls(**{name: getattr(fields, name) for name in names})

    @classmethod
    def preset(cls, name: str) -> "Board":
        """Return the preset `name`, one of `preset_names()`; BoardError for an unknown name."""
        return _preset(name)

    @classmethod
    def triangle(cls, rows: int, *, risk: Risk = "medium", **changes: Any) -> "Board":
        """Return the triangular board of `rows` rows, 4 to 20, with `changes` as for `replace`.

        From 8 to 16 rows it is the preset with the payout table of `risk`: low, medium or high.
        On other triangles every bin returns the stake, unless `bins={"multipliers": …}` is given.
        With changes its name is `triangle of 8 rows`, because it is no longer the preset.
        """
        fields = making.triangle_fields(rows, risk)
        if changes:
            changes = {"name": f"triangle of {rows} rows"} | changes
        return cls(**making.replaced(fields, changes))

    def replace(self, **changes: Any) -> "Board":
        """Return a new checked board with some fields changed.

        A mapping changes some fields of a part; any other value replaces the whole part:
        `board.replace(gravity=1.62, ball={"radius": 0.1})`. Raises BoardError.
        """
        return type(self)(**making.replaced(self, changes))

    def with_restitution(self, e: float) -> "Board":
        """Return the board with restitution `e` in every contact: of ball, pegs and walls.

        Of two surfaces the greater restitution counts, so a change of one may have no effect.
        """
        surface = {"restitution": e}
        return self.replace(ball=surface, peg_material=surface, wall_material=surface)

    def with_friction(self, mu: float) -> "Board":
        """Return the board with friction `mu` in every contact: of ball, pegs and walls."""
        surface = {"friction": mu}
        return self.replace(ball=surface, peg_material=surface, wall_material=surface)

    @classmethod
    def named(cls, board: object) -> "Board":
        """Return `board` itself if it is a Board, or the preset of that name.

        Every function that takes a board calls this. Raises BoardError for anything else, such as
        the path of a file.
        """
        if isinstance(board, Board):
            return board
        if isinstance(board, str) and board in presets.preset_names():
            return _preset(board)
        raise values.fail(
            "board",
            board,
            "it must be a Board or the name of a preset (engine.preset_names() lists them); "
            "Board.from_json reads one from a file, from JSON text or from a dict",
        )

    @classmethod
    def from_json(cls, source: str | os.PathLike[str] | Mapping[str, Any]) -> "Board":
        """Make a board from its JSON form: text (starts with `{`), the path of a file, or a dict.

        Raises BoardError, whose `faults` list every fault.
        """
        faults = Faults()
        fields = json_form.fields(json_form.load(source), faults)
        if faults.found:
            for key, value in fields.items():
                faults.take(values.CHECKS[key], value)
            faults.end()
        return cls(**fields)

    @classmethod
    def kept(cls, form: Mapping[str, Any]) -> "Board":
        """Return a board that was accepted earlier, from its JSON form.

        The values are checked, but not the board as a whole: a board from the ledger must stay
        readable even if newer checks would refuse it. The caller compares the digest.
        """
        faults = Faults()
        fields = json_form.fields(form, faults)
        faults.end()
        return cls(**fields, is_kept=True)

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form."""
        return json_form.to_dict(self)

    def to_json(self) -> str:
        """Return the JSON form as text, from which `Board.from_json` makes an equal board."""
        return json_form.dumps(self)

    @property
    def preset_name(self) -> str | None:
        """Name of the preset that this board equals, or None."""
        return self.name if payouts.NAMES.get(self.digest) == self.name else None


@functools.cache
def _preset(name: str) -> Board:
    return Board.of(presets.preset_fields(name))
