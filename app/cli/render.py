"""`plinko render`: a drop as a picture file."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from app.cli import common

if TYPE_CHECKING:
    from engine import Drop

STILLS = (".png", ".jpg", ".webp")
ANIMATIONS = (".gif", ".webp", ".apng")


@click.command(name="render", short_help="Draw a drop into a picture file.")
@common.board_argument
@click.argument("out", metavar="OUT")
@common.start_options
@common.solver_options
@click.option("--at", type=float, metavar="T", help="The moment T seconds after the start.")
@click.option("--width", type=int, default=760, show_default=True, help="In pixels, 240 to 2048.")
@click.option("--fps", type=int, default=30, show_default=True, help="Of an animation, 1 to 60.")
@click.option(
    "--theme", default="light", show_default=True, help="Colours: the page's light or dark."
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
    at: float | None,
    width: int,
    fps: int,
    theme: str,
) -> None:
    """Draw a drop on BOARD into the file OUT; its ending says how.

    .png and .jpg: the whole path. .gif, .webp and .apng: as it falls. With --at, .png, .jpg and
    .webp: one moment.
    """
    path = _writable(out, STILLS if at is not None else (*STILLS, *ANIMATIONS))
    how = common.read_solver(solver, dt, substeps, correction)
    number = common.read_seed(seed)

    from engine import drop

    d = drop(common.load_board(board), seed=number, x=x, **how)
    picture = _draw(d, path.suffix.lower()[1:], at, width, fps, theme)
    path.write_bytes(picture)
    click.echo(f"{out}: {len(picture):,} bytes")


def _draw(d: "Drop", fmt: str, at: float | None, width: int, fps: int, theme: str) -> bytes:
    from app.render import drop_animation, drop_picture

    if at is None and f".{fmt}" in ANIMATIONS:
        return drop_animation(d, fmt, width, fps, theme)
    return drop_picture(d, fmt, width, theme, at)


def _writable(out: str, endings: tuple[str, ...]) -> Path:
    """The file to write; UsageError for an ending that is no format, or without its folder."""
    path = Path(out)
    if path.suffix.lower() not in endings:
        known = ", ".join(dict.fromkeys(endings))
        raise click.UsageError(f"OUT {out!r} must end in one of {known}")
    if not path.parent.is_dir():
        raise click.UsageError(f"OUT {out!r}: there is no folder {str(path.parent)!r}")
    return path
