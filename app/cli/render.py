"""`plinko render`: a drop as a picture file."""

from pathlib import Path

import click

from app.cli import common


@click.command(name="render", short_help="Draw a drop into a picture file.")
@common.board_argument
@click.argument("out", metavar="OUT.png|.gif|.webp")
@common.start_options
@common.solver_options
@click.option(
    "--width",
    type=int,
    default=760,
    show_default=True,
    help="Of the picture, in pixels.",
)
@click.option(
    "--fps",
    type=int,
    default=30,
    show_default=True,
    help="Frames per second of a .gif or .webp.",
)
def command(
    board: str,
    out: str,
    seed: str,
    x: float | None,
    solver: str,
    dt: float | None,
    substeps: int | None,
    correction: float | None,
    width: int,
    fps: int,
) -> None:
    """Draw a drop on BOARD into a file: its whole path (.png), or as it falls (.gif, .webp)."""
    path = Path(out)
    kind = path.suffix.lower()
    if kind not in {".png", ".gif", ".webp"}:
        raise click.UsageError(f"OUT {out!r} must end in .png, .gif or .webp")
    if not path.parent.is_dir():
        raise click.UsageError(f"OUT {out!r}: there is no folder {str(path.parent)!r}")
    how = common.read_solver(solver, dt, substeps, correction)
    number = common.read_seed(seed)

    from app.render import drop_animation, drop_png
    from engine import drop

    d = drop(common.load_board(board), seed=number, x=x, **how)
    if kind == ".png":
        picture = drop_png(d, width)
    else:
        picture = drop_animation(d, kind[1:], width=width, fps=fps)
    path.write_bytes(picture)
    click.echo(f"{out}: {len(picture):,} bytes")
