"""What the subcommands share: the BOARD argument, the options of a drop, and how they are read."""

import json
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from engine import Board

Command = TypeVar("Command", bound=Callable[..., Any])

DEFAULT_DT = 1 / 60  # s, the stepped solver's frame
DEFAULT_SUBSTEPS = 4


class Seconds(click.ParamType):
    """A duration in seconds, as a decimal or as a fraction: `0.01` or `1/240`."""

    name = "seconds"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return the value as a float; the range is the engine's to check."""
        if isinstance(value, float):
            return value
        numerator, _, denominator = str(value).partition("/")
        try:
            return float(numerator) / float(denominator or 1)
        except (ValueError, ZeroDivisionError):
            self.fail(f"{value!r} is neither a number of seconds nor a fraction such as 1/240.")


@dataclass(frozen=True)
class Solver:
    """How to compute a drop: the solver's name and, for `stepped`, its step (s) and substeps."""

    name: str
    dt: float
    substeps: int

    @property
    def options(self) -> dict[str, Any]:
        """Keyword arguments for `engine.drop` and `engine.drop_many`."""
        return {"solver": self.name, "dt": self.dt, "substeps": self.substeps}

    def __str__(self) -> str:
        if self.name == "exact":
            return "exact"
        return f"stepped, dt {self.dt:.6g} s, {self.substeps} substeps"


def board_argument(command: Command) -> Command:
    """Add the BOARD argument, passed as the string `board`."""
    return click.argument("board")(command)


def start_options(command: Command) -> Command:
    """Add --seed and --x, which say where a drop starts: the strings `seed` and the float `x`."""
    command = click.option(
        "--x", type=float, help="Start here (metres) instead of where the seed says."
    )(command)
    # A string, so that the engine's own parser names what is wrong with a seed.
    return click.option("--seed", required=True, help="An integer from 0 to 2^64 - 1.")(command)


def solver_options(command: Command) -> Command:
    """Add --solver, --dt and --substeps; read them with `read_solver`."""
    command = click.option(
        "--substeps", type=int, help=f"Substeps of a step, stepped only. [{DEFAULT_SUBSTEPS}]"
    )(command)
    command = click.option(
        "--dt", type=Seconds(), help="Step, stepped only: 0.01 or 1/240. [1/60]"
    )(command)
    return click.option(
        "--solver",
        type=click.Choice(["exact", "stepped"]),
        default="exact",
        show_default=True,
        help="Event-driven, or with a fixed time step.",
    )(command)


def read_solver(solver: str, dt: float | None, substeps: int | None) -> Solver:
    """The solver that the options ask for; --dt with the exact solver is a UsageError."""
    if solver == "exact":
        for name, value in (("--dt", dt), ("--substeps", substeps)):
            if value is not None:
                raise click.UsageError(
                    f"{name} {value} belongs to --solver stepped: exact has no time step"
                )
    return Solver(
        solver,
        DEFAULT_DT if dt is None else dt,
        DEFAULT_SUBSTEPS if substeps is None else substeps,
    )


def load_board(name: str) -> "Board":
    """The preset called `name`, or the board in the JSON file at that path.

    Raises UsageError when it is neither, BoardError when the file is no board that can be played.
    """
    from engine import Board, preset_names

    if name in preset_names():
        return Board.preset(name)
    path = Path(name)
    if path.is_file():
        return Board.from_json(path)
    raise click.UsageError(
        f"BOARD {name!r} is neither a preset (`plinko boards` lists them) nor a JSON file"
    )


def read_seed(text: str) -> int:
    """`text` as a seed; raises SeedError naming it."""
    from engine.seeding import parse_seed

    return parse_seed(text)


def print_json(value: object) -> None:
    """Print one object on one line; floats in shortest round-trip form, never NaN or infinity."""
    click.echo(json.dumps(value, ensure_ascii=False, allow_nan=False))


def print_fields(fields: dict[str, str]) -> None:
    """Print `name  value` lines in two aligned columns."""
    width = max(map(len, fields))
    for name, value in fields.items():
        click.echo(f"{name:<{width}}  {value}")


def stderr_is_terminal() -> bool:
    """Whether somebody watches stderr: a progress bar in a log file helps nobody."""
    return sys.stderr.isatty()
