"""What the subcommands share: the BOARD argument, the options of a drop, and how they are read."""

import gc
import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from datetime import timedelta
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from engine import Board
    from engine.batches.workers import Workers
    from engine.parameters import Solver

Command = TypeVar("Command", bound=Callable[..., Any])


Options = dict[str, Any]
"""Keyword arguments of `engine.drops.drop` and `engine.drop_many` that choose the solver."""


@contextmanager
def garbage_waits() -> Iterator[None]:
    """Look for no garbage meanwhile: what the start of a program makes stays.

    Also a decorator. The engine's compiler does the same for itself, but to import it is the start.
    """
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


def board_argument(command: Command) -> Command:
    """Add the BOARD argument, passed as the string `board`."""
    return click.argument("board")(command)


def start_options(command: Command) -> Command:
    """Add --seed, --x and --aim, which say where a drop starts: a string and two floats."""
    # A string, so that the engine's own parser names what is wrong with a seed.
    with_seed = click.option("--seed", help="An integer from 0 to 2^64 - 1.")
    return with_seed(x_option(aim_option(command)))


def read_start(seed: str | None, x: float | None) -> int | None:
    """The seed of a drop, or None where only --x says where it starts.

    Raises UsageError when neither is given, SeedError for a seed that is none.
    """
    if seed is None and x is None:
        raise click.UsageError("a drop needs a start: --seed N or --x X")
    return None if seed is None else read_seed(seed)


def x_option(command: Command) -> Command:
    """Add --x, an explicit start."""
    return click.option(
        "--x", type=float, help="Start here (metres) instead of where the seed says."
    )(command)


def aim_option(command: Command) -> Command:
    """Add --aim, the middle of the starts that seeds draw."""
    return click.option("--aim", type=float, help="The seed draws the start about here (metres).")(
        command
    )


def _seconds(ctx: click.Context, param: click.Parameter, value: str | None) -> float | None:
    """A duration in seconds, as a decimal or a fraction; its range is the engine's to check."""
    if value is None:
        return None
    numerator, _, denominator = value.partition("/")
    try:
        return float(numerator) / float(denominator or 1)
    except (ValueError, ZeroDivisionError):
        raise click.BadParameter(
            f"{value!r} is neither a number of seconds nor a fraction such as 1/240",
            ctx=ctx,
            param=param,
        ) from None


def solver_options(command: Command) -> Command:
    """Add --solver, --dt, --substeps and --correction; read them with `read_solver`."""
    for option in (
        click.option("--correction", type=float, help="Of an overlap, per substep. [0.6]"),
        click.option("--substeps", type=int, help="Substeps of a step. [4]"),
        click.option("--dt", callback=_seconds, metavar="S", help="Step in s, as 1/240. [1/60]"),
        click.option(
            "--solver",
            type=click.Choice(["exact", "stepped"]),
            default="exact",
            show_default=True,
            help="Event-driven, or with a fixed time step.",
        ),
    ):
        command = option(command)
    return command


def cluster_option(command: Command) -> Command:
    """Add --cluster, which says where it is computed; open it with `workers`."""
    return click.option(
        "--cluster",
        metavar="WHERE",
        help="Workers elsewhere: local[:N] processes, or a Dask scheduler's tcp://host:8786.",
    )(command)


def workers_options(command: Command) -> Command:
    """Add --threads and --cluster."""
    threads = click.option("--threads", type=click.IntRange(min=1), help="Default: every core.")
    return threads(cluster_option(command))


def workers(cluster: str | None, threads: int | None) -> "AbstractContextManager[Workers]":
    """The workers that --cluster and --threads ask for; see `workers_at` for errors."""
    from engine.batches.workers import workers_at

    return workers_at(cluster, threads)


@contextmanager
def progress(length: int, label: str, done: int = 0) -> Iterator[Callable[[int], None] | None]:
    """A bar on stderr with rate and time left, where somebody sees it, and else nothing.

    What is told to it is how many are done, of which `done` were before.
    """
    if not sys.stderr.isatty():
        yield None
        return
    began = time.monotonic()
    with click.progressbar(length=length, label=label, show_eta=False, file=sys.stderr) as bar:
        bar.update(done)

        def told(now: int) -> None:
            rate = (now - done) / max(time.monotonic() - began, 1e-9)
            left = timedelta(seconds=min(round((length - now) / max(rate, 1e-9)), 10**13))
            bar.label = f"{label}, {rate:,.0f}/s, {left} left"
            bar.update(now - bar.pos)

        yield told


def read_solver(
    solver: str, dt: float | None, substeps: int | None, correction: float | None
) -> Options:
    """The solver that the options ask for, as keyword arguments; what is unset keeps its default.

    Raises UsageError for a parameter of the stepped solver beside the exact one.
    """
    given = {"dt": dt, "substeps": substeps, "correction": correction}
    options: Options = {name: value for name, value in given.items() if value is not None}
    if solver == "exact":
        for name, value in options.items():
            raise click.UsageError(
                f"--{name} {value:g} belongs to --solver stepped: exact has no time step"
            )
    return {"solver": solver} | options


def describe_solver(solver: "Solver") -> str:
    """A solver with its parameters, for people."""
    parameters = [f"{name} {value:.6g}" for name, value in solver.fields().items()]
    return ", ".join([solver.name, *parameters])


def load_board(name: str) -> "Board":
    """The preset called `name`, or the board in the JSON file at that path.

    Raises UsageError when it is neither, BoardError when the file is no board that can be played.
    """
    from engine import Board, BoardError, preset_names

    if name in preset_names():
        return Board.preset(name)
    path = Path(name)
    if path.is_file():
        try:
            return Board.from_json(path)
        except BoardError as error:
            raise BoardError(f"{name}: {error}", field=error.field, faults=error.faults) from None
    raise click.UsageError(
        f"BOARD {name!r} is neither a preset (`plinko boards` lists them) nor a JSON file"
    )


def counted(count: int, one: str) -> str:
    """'1 drop', '2 drops'."""
    return f"{count:,} {one}{'s' * (count != 1)}"


def need_certifier() -> None:
    """Raise UsageError unless python-flint is installed, which the certified solver uses."""
    _need("flint", "proofs need python-flint, which is not installed", "certify")


def need_server() -> None:
    """Raise UsageError unless the packages that a server needs are installed."""
    _need("sqlalchemy", "this command needs the server, which is not installed", "server")


def _need(module: str, message: str, extra: str) -> None:
    if find_spec(module) is None:
        raise click.UsageError(f"{message}: pip install 'plinko-server[{extra}]'")


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
