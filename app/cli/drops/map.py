"""`plinko map`: draw the proven bin of every start, zooming in by factors of ten."""

import click

from plinko.app.batches.files import write_whole
from plinko.app.cli import common


@click.command(name="map", short_help="Draw the bin as a function of the start, proven.")
@common.board_argument
@click.argument("out", metavar="OUT")
@click.option("--x", default="0", help="Zoom in on this start (metres), exact.")
@click.option(
    "--levels",
    type=click.IntRange(1, 41),
    default=31,
    help="Number of strips; each shows a tenth of the one above it.",
)
@click.option("--pixels", type=click.IntRange(1, 4096), default=256, help="Width of a strip.")
@click.option("--theme", default="light", help="Colours: light or dark.")
def command(board: str, out: str, x: str, levels: int, pixels: int, theme: str) -> None:
    """Draw into OUT (.png, .jpg, .webp) the bin to which each start on BOARD leads.

    Each strip shows the starts around --x ten times larger than the strip above, far beyond the
    resolution of double precision. Each pixel is proven, which takes some hundredths of a second
    unless one proof covers many pixels. White: the ball stays on the board. Grey: undecided.
    """
    path = common.writable(out, (".png", ".jpg", ".webp"))
    common.need_certifier()
    from plinko.app.render.start_map import map_picture
    from plinko.engine.certified.start_map import strip_at

    chosen = common.load_board(board)
    strips = []
    with common.progress(levels, "strips") as progress:
        for level in range(levels):
            strips.append(strip_at(chosen, x, level, pixels))
            if progress is not None:
                progress(level + 1)
    picture = map_picture(chosen, strips, path.suffix[1:].lower(), theme)
    write_whole(path, picture)
    common.echo(f"{out}: {len(picture):,} bytes, {sum(strip.proofs for strip in strips):,} proofs")
