"""`plinko boards`: list the presets, or print one board as JSON."""

from typing import TYPE_CHECKING

import click

from plinko.app.cli import common

if TYPE_CHECKING:
    from plinko.engine.payouts.listing import Listed


@click.command(name="boards", short_help="List the preset boards, or print one as JSON.")
@click.argument("board", required=False)
@click.option("--json", "as_json", is_flag=True, help="Print the list as JSON.")
def command(board: str | None, as_json: bool) -> None:
    """List the preset boards; with BOARD, check that board and print it as JSON.

    A board with a return takes stakes; the others are for practice.

    Every command takes a file with such JSON as BOARD: edit it to make your own board.
    """
    if board is not None:
        common.echo(common.load_board(board).to_json())
        return

    from plinko.engine import preset_names
    from plinko.engine.payouts.listing import listed

    boards = [listed(name) for name in preset_names()]
    if as_json:
        common.print_json([_summary(each) for each in boards])
        return
    rows = [_row(each) for each in boards]
    headings = ("name", "pegs", "bins", "pays", "return", "size", "digest")
    widths = [max(map(len, column)) for column in zip(headings, *rows, strict=True)]
    for row in (headings, *rows):
        cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        common.echo("  ".join(cells).rstrip())


def _summary(board: "Listed") -> dict[str, object]:
    """A board's row in the list, with the field names of `GET boards`."""
    width, height = board.size
    return {
        "name": board.name,
        "digest": board.digest,
        "stakes": board.stakes,
        "world": board.world,
        "rows": board.rows,
        "risk": board.risk,
        "pegs": board.pegs,
        "bins": board.bins,
        "multipliers": list(board.multipliers),
        "return": board.returned,
        "top_multiplier": max(board.multipliers),
        "width": width,
        "height": height,
    }


def _row(board: "Listed") -> tuple[str, ...]:
    pays = board.multipliers
    width, height = board.size
    return (
        board.name,
        str(board.pegs),
        str(board.bins),
        f"{min(pays):g} to {max(pays):g}",
        f"{board.returned:.2%}" if board.returned is not None and board.stakes else "practice",
        f"{width:.4g} x {height:.4g} m",
        board.digest[:16],
    )
