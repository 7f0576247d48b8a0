"""Arguments and options that several subcommands share, and functions that read and print them."""

import codecs
import functools
import gc
import io
import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from datetime import timedelta
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar

import click

if TYPE_CHECKING:
    from plinko.engine import Board, Drop
    from plinko.engine.batches.workers import Workers
    from plinko.engine.parameters import Solver

Command = TypeVar("Command", bound=Callable[..., Any])


Options = dict[str, Any]
"""The solver, as keyword arguments of `plinko.engine.drop` and `plinko.engine.drop_many`."""

COUNT: Final = click.IntRange(min=1)
IN: Final = click.Path(exists=True, dir_okay=False, path_type=Path)
OUT: Final = click.Path(dir_okay=False, path_type=Path)


@contextmanager
def garbage_waits() -> Iterator[None]:
    """Collect no garbage during imports: the objects they create stay anyway.

    Also works as a decorator. The engine's compiler does the same, but only after its own import.
    """
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


board_argument: Final = click.argument("board")

# A string, so that the engine's parser reports an invalid seed.
seed_option: Final = click.option("--seed", help="An integer from 0 to 2^64 - 1.")

x_option: Final = click.option(
    "--x", type=float, help="Start here (metres) instead of drawing the start by the seed."
)
aim_option: Final = click.option(
    "--aim", type=float, help="The seed draws the start near here (metres)."
)
cluster_option: Final = click.option(
    "--cluster",
    metavar="WHERE",
    help="Compute in local[:N] processes, or on the Dask cluster at tcp://host:8786.",
)
threads_option: Final = click.option(
    "--threads", type=COUNT, help="Threads to compute with. [one per core]"
)


def workers_options(command: Command) -> Command:
    return threads_option(cluster_option(command))


def dropped(
    board: str, seed: str | None, x: float | None, aim: float | None, how: Options
) -> "Drop":
    """Compute one drop; UsageError if neither --seed nor --x is given."""
    from plinko.engine import drop

    if seed is None and x is None:
        raise click.UsageError("a drop needs a start: give --seed N or --x X")
    number = None if seed is None else read_seed(seed)
    return drop(load_board(board), number, x=x, aim=aim, **how)


def _seconds(ctx: click.Context, param: click.Parameter, value: str | None) -> float | None:
    """Parse seconds as a decimal or a fraction; the engine checks the range."""
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


def solver_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add --solver, --dt, --substeps and --correction, which the command gets as `how`: Options."""

    @functools.wraps(command)
    def with_solver(
        *, solver: str, dt: float | None, substeps: int | None, correction: float | None,
        **others: Any,
    ) -> Any:  # fmt: skip
        return command(how=_read_solver(solver, dt, substeps, correction), **others)

    for option in (
        click.option(
            "--correction", type=float, help="Share of an overlap removed per substep. [0.6]"
        ),
        click.option("--substeps", type=int, help="Substeps per step. [4]"),
        click.option(
            "--dt", callback=_seconds, metavar="S", help="Seconds per step, such as 1/240. [1/60]"
        ),
        click.option(
            "--solver",
            type=click.Choice(["exact", "stepped"]),
            default="exact",
            help="exact: from impact to impact; stepped: with a fixed time step.",
        ),
    ):
        with_solver = option(with_solver)
    return with_solver


def workers(cluster: str | None, threads: int | None) -> "AbstractContextManager[Workers]":
    """Open the workers of --cluster and --threads; see `workers_at` for errors."""
    from plinko.engine.batches.workers import workers_at

    return workers_at(cluster, threads)


@contextmanager
def progress(length: int, label: str, done: int = 0) -> Iterator[Callable[..., None] | None]:
    """Show a bar with rate and time left on stderr, or yield None if stderr is not a terminal.

    Call the yielded function with the number done in all, and with the length if it changes. `done`
    of them are from an earlier run and do not count for the rate.
    """
    if not sys.stderr.isatty():
        yield None
        return
    began = time.monotonic()
    with click.progressbar(length=length, label=label, show_eta=False, file=sys.stderr) as bar:
        bar.update(done)

        def report(now: int, of: int = length) -> None:
            rate = (now - done) / max(time.monotonic() - began, 1e-9)
            left = timedelta(seconds=min(round((of - now) / max(rate, 1e-9)), 10**13))
            bar.length = of
            bar.label = f"{label}, {rate:,.0f}/s, {left} left"
            bar.update(now - bar.pos)

        yield report


def writable(out: str, endings: tuple[str, ...]) -> Path:
    """Raises UsageError if the ending is not in `endings`, or the folder does not exist."""
    path = Path(out)
    if path.suffix.lower() not in endings:
        known = ", ".join(dict.fromkeys(endings))
        raise click.UsageError(f"OUT {out!r} must end in one of {known}")
    if not path.parent.is_dir():
        raise click.UsageError(f"OUT {out!r}: there is no folder {str(path.parent)!r}")
    return path


def _read_solver(
    solver: str, dt: float | None, substeps: int | None, correction: float | None
) -> Options:
    """The solver's options as keyword arguments, without the unset ones.

    Raises UsageError if a parameter of the stepped solver is given with the exact one.
    """
    given = {"dt": dt, "substeps": substeps, "correction": correction}
    options: Options = {name: value for name, value in given.items() if value is not None}
    if solver == "exact":
        for name, value in options.items():
            raise click.UsageError(
                f"--{name} {value:g} needs --solver stepped: the exact solver has no time step"
            )
    return {"solver": solver} | options


def describe_solver(solver: "Solver") -> str:
    parameters = [f"{name} {value:.6g}" for name, value in solver.fields().items()]
    return ", ".join([solver.name, *parameters])


def load_board(name: str) -> "Board":
    """The preset called `name`, or the board in the JSON file at that path.

    Raises UsageError if it is neither, BoardError if the file is not a playable board.
    """
    from plinko.engine import Board, BoardError, preset_names

    if name in preset_names():
        return Board.preset(name)
    path = Path(name)
    if path.exists() and not path.is_dir():  # a file, or a pipe such as /dev/stdin
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
    """Raise UsageError unless python-flint, which the certified solver uses, is installed."""
    _need("flint", "proofs need python-flint, which is not installed", "certify")


def need_server() -> None:
    """Raise UsageError unless the packages that a server needs are installed."""
    _need("sqlalchemy", "this command needs the server, which is not installed", "server")


def _need(module: str, message: str, extra: str) -> None:
    if find_spec(module) is None:
        raise click.UsageError(f"{message}: pip install 'plinko-sim[{extra}]'")


def read_seed(text: str) -> int:
    from plinko.engine.seeding import parse_seed

    return parse_seed(text)


def echo(text: object = "", *, err: bool = False, nl: bool = True) -> None:
    """Print to stdout or stderr; `escape_output` decides what becomes of other characters."""
    # Without a file, click takes a terminal of ASCII for a mistake and writes UTF-8 to it.
    click.echo(text, file=sys.stderr if err else sys.stdout, nl=nl)


def escape_output() -> None:
    """Have stdout and stderr escape what their encoding lacks, as JSON does, instead of failing."""
    codecs.register_error(_ESCAPED, _escaped)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=_ESCAPED)


_ESCAPED: Final = "plinko.escaped"


def _escaped(error: UnicodeError) -> tuple[str, int]:
    r"""Replace characters by `\u0141`, those beyond 16 bits by two of these: so JSON stays JSON."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return json.dumps(error.object[error.start : error.end])[1:-1], error.end


def print_json(value: object) -> None:
    """Print `value` as one line of JSON. Raises ValueError for NaN and infinity.

    JSON is read as UTF-8: any other output, such as one redirected on Windows, is in ASCII.
    """
    encoding = codecs.lookup(sys.stdout.encoding or "ascii").name
    echo(json.dumps(value, ensure_ascii=encoding != "utf-8", allow_nan=False))


def print_fields(fields: dict[str, str]) -> None:
    """Print `name  value` lines in two aligned columns."""
    width = max(map(len, fields))
    for name, value in fields.items():
        echo(f"{name:<{width}}  {value}")
