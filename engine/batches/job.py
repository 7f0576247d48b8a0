"""A job: drops of consecutive seeds, divided into blocks that any worker can compute."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from plinko.engine.board.model import Board
from plinko.engine.constants import PHYSICS_VERSION
from plinko.engine.drops.digest import BLOCK
from plinko.engine.drops.start import aim_of
from plinko.engine.drops.verify import board_of
from plinko.engine.errors import EngineError, ParameterError, RecordError, shorten
from plinko.engine.parameters import Solver, Stepped, make_solver
from plinko.engine.seeding import SEED_LIMIT, parse_seed


@dataclass(frozen=True, init=False)
class Job:
    """`drops` drops with the seeds `first`, `first` + 1, …, and all that decides their outcomes.

    board: a Board, or a preset's name. aim: the middle of the starts that seeds draw, m; None for
    the board's own. Block k begins with the seed `first` + k * BLOCK. Raises ParameterError or
    SeedError for a value out of range.
    """

    board: Board
    solver: Solver
    first: int
    drops: int
    aim: float | None

    def __init__(
        self,
        board: Board | str,
        solver: Solver,
        first: int,
        drops: int,
        aim: float | None = None,
    ) -> None:
        board = Board.named(board)
        if drops < 1:
            raise ParameterError(f"drops is {drops!r}: it must be at least 1", field="drops")
        parse_seed(first)
        parse_seed(first + drops - 1)
        vars(self).update(
            board=board,
            solver=solver,
            first=first,
            drops=drops,
            aim=None if aim is None else aim_of(board, aim),
        )

    @property
    def blocks(self) -> int:
        """Number of blocks; the last may have fewer drops than the others."""
        return -(-self.drops // BLOCK)

    def seeds(self, number: int) -> range:
        """The seeds of the block `number`."""
        begin = BLOCK * number
        return range(self.first + begin, self.first + min(begin + BLOCK, self.drops))

    @property
    def options(self) -> dict[str, Any]:
        """Solver and aim as keyword arguments of `drop_many`."""
        return {"solver": self.solver.name, **self.solver.fields(), "aim": self.aim}

    def to_dict(self) -> dict[str, Any]:
        """The JSON form, which `job_of` reads. Two jobs are the same if their forms are equal."""
        return {
            "board": self.board.preset_name or self.board.to_dict(),
            "board_digest": self.board.digest,
            "physics_version": PHYSICS_VERSION,
            "solver": self.solver.name,
            **self.solver.fields(),
            "seed": str(self.first),
            "aim": self.aim,
            "asked": self.drops,
        }


def job_of(form: Mapping[str, Any]) -> Job:
    """Read a job from its JSON form; RecordError if it is malformed or has other physics."""
    board = board_of({"board": wanted(form, "board")})
    for name, ours in (("board_digest", board.digest), ("physics_version", PHYSICS_VERSION)):
        if wanted(form, name) != ours:
            raise RecordError(
                f"{name} is {shorten(form[name])}, but here it is {ours!r}: use the release that "
                "computed the result",
                field=name,
            )
    how = {name: form[name] for name in Stepped().fields() if name in form}
    drops = whole(wanted(form, "asked"), "asked", SEED_LIMIT)
    try:
        solver = make_solver(wanted(form, "solver"), **how)
        return Job(board, solver, parse_seed(wanted(form, "seed")), drops, form.get("aim"))
    except EngineError as error:
        raise RecordError(str(error), field=error.field) from error


def wanted(form: Mapping[str, Any], name: str) -> Any:
    """Return a required field of a batch's result; RecordError if it is missing."""
    if name not in form:
        raise RecordError(f"{name!r} is missing from the result of a batch", field=name)
    return form[name]


def listed(form: Mapping[str, Any], name: str) -> list[Any]:
    """Return a required field that is a list; RecordError otherwise."""
    value = wanted(form, name)
    if not isinstance(value, list):
        raise RecordError(f"{name} is {shorten(value)}: it must be a list", field=name)
    return value


def whole(value: Any, name: str, most: int) -> int:
    """Return `value`, a whole number from 0 to `most`; RecordError otherwise."""
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= most:
        raise RecordError(
            f"{name} is {shorten(value)}: it must be a whole number from 0 to {most}",
            field=name,
        )
    return value
