"""`plinko render`: draw one drop or many drops into a picture file."""

from contextlib import nullcontext
from typing import TYPE_CHECKING

import click

from plinko.app.batches.files import write_whole
from plinko.app.cli import common
from plinko.engine.json_text import Json

if TYPE_CHECKING:
    from plinko.app.render.raster.encode import Still
    from plinko.engine import Board, Drop

STILLS = (".png", ".jpg", ".webp")
ANIMATIONS = (".gif", ".webp", ".apng", ".mp4")
MANY = ("sheet", "density", "histogram")


@click.command(name="render", short_help="Draw a drop, or many, into a picture file.")
@common.board_argument
@click.argument("out", metavar="OUT")
@click.option("--seed", help="An integer from 0 to 2^64 - 1; the first of many.  [many: 0]")
@common.x_option
@common.aim_option
@common.solver_options
@click.option("--at", type=float, metavar="T", help="Draw the moment T seconds after the start.")
@click.option("--sheet", type=int, metavar="N", help="Draw N drops side by side, at most 256.")
@click.option("--columns", type=int, help="Columns of the sheet.  [as many as rows, if they fit]")
@click.option("--density", type=int, metavar="N", help="Draw where N drops spend their time.")
@click.option("--histogram", type=int, metavar="N", help="Draw where N drops land.")
@common.cluster_option
@click.option("--width", type=int, help="Width in pixels.  [760; a sheet 1140]")
@click.option(
    "--fps",
    type=int,
    default=30,
    help="Frames per second of an animation, 1 to 60; a GIF has at most 50.",
)
@click.option("--theme", default="light", help="Colours: light or dark.")
def command(  # one parameter per option: click passes them by name
    board: str,
    out: str,
    seed: str | None,
    x: float | None,
    aim: float | None,
    how: common.Options,
    at: float | None,
    columns: int | None,
    cluster: str | None,
    width: int | None,
    fps: int,
    theme: str,
    **many: int | None,
) -> None:
    """Draw drops on BOARD into the file OUT; its ending chooses the format.

    One drop (--seed or --x): its path (.png, .jpg), an animation (.gif, .webp, .apng, .mp4), or
    one moment (--at; .png, .jpg, .webp). Many drops (--sheet, --density or --histogram N; .png,
    .jpg, .webp): those of N seeds from --seed on.
    """
    asked = {name: count for name, count in many.items() if count is not None}
    if cluster is not None and set(asked) != {"density"}:
        raise click.UsageError(f"--cluster {cluster} works only with --density")
    path = common.writable(out, STILLS if asked or at is not None else (*STILLS, *ANIMATIONS))
    fmt: Json = path.suffix.lower()[1:]
    given = {"width": width, "columns": columns, "theme": theme}
    sizes: dict[str, Json] = {name: v for name, v in given.items() if v is not None}
    if asked:
        _check_many(asked, columns=columns, solver=how["solver"], x=x, aim=aim, at=at)
        ((kind, count),) = asked.items()
        seeds = _seeds(seed, count, kind)
        picture = _draw_many(kind, common.load_board(board), seeds, fmt, cluster, how, sizes)
    else:
        if columns is not None:
            raise click.UsageError(f"--columns {columns} works only with --sheet")
        picture = _draw_one(common.dropped(board, seed, x, aim, how), fmt, at, fps, sizes)
    write_whole(path, picture)
    common.echo(f"{out}: {len(picture):,} bytes")


def _draw_one(d: "Drop", fmt: Json, at: float | None, fps: int, sizes: dict[str, Json]) -> bytes:
    from plinko.app.render import drop_animation, drop_picture

    if at is None and f".{fmt}" in ANIMATIONS:
        return drop_animation(d, fmt, fps=fps, **sizes)
    return drop_picture(d, fmt, at=at, **sizes)


def _draw_many(
    kind: str,
    board: "Board",
    seeds: range,
    fmt: "Still",
    cluster: str | None,
    how: common.Options,
    sizes: dict[str, Json],
) -> bytes:
    from plinko.app.render import contact_sheet, density_picture, histogram_picture
    from plinko.engine import drop_many

    with (
        nullcontext() if cluster is None else common.workers(cluster, None) as workers,
        common.progress(len(seeds), "drops") as progress,
    ):
        if kind == "sheet":
            return contact_sheet(board, seeds, fmt, progress=progress, **sizes)
        if kind == "density":
            sizes |= {"progress": progress, "workers": workers}
            return density_picture(board, seeds, fmt, **sizes)
        batch = drop_many(board, seeds, progress=progress, **how)
        unsettled = batch.unsettled_count
        return histogram_picture(board, batch.histogram, fmt, unsettled_count=unsettled, **sizes)


def _check_many(
    asked: dict[str, int], *, columns: int | None, solver: str, **of_one: float | None
) -> None:
    """Raise UsageError for options that do not go together."""
    names = [f"--{name} {count}" for name, count in asked.items()]
    if len(asked) > 1:
        raise click.UsageError(f"{' and '.join(names)}: give only one of them")
    for name, value in of_one.items():
        if value is not None:
            raise click.UsageError(f"--{name} {value:g} is for one drop, not for {names[0]}")
    if columns is not None and "sheet" not in asked:
        raise click.UsageError(f"--columns {columns} is for --sheet, not for {names[0]}")
    if solver != "exact" and "histogram" not in asked:
        raise click.UsageError(f"--solver {solver}: {names[0]} needs --solver exact")


def _seeds(first: str | None, count: int, kind: str) -> range:
    """Raises UsageError if `count` is below 1, SeedError if any seed is invalid."""
    if count < 1:
        raise click.UsageError(f"--{kind} {count}: the number of drops must be at least 1")
    start = common.read_seed(first or "0")
    common.read_seed(str(start + count - 1))
    return range(start, start + count)
