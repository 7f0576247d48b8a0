"""`plinko boards`: list the presets, or print one board as JSON."""

from typing import TYPE_CHECKING

import click

from app.cli import common

if TYPE_CHECKING:
    from engine import Board


@click.command(name="boards", short_help="List the preset boards, or print one as JSON.")
@click.argument("board", required=False)
@click.option("--json", "as_json", is_flag=True, help="Print the list as JSON.")
def command(board: str | None, as_json: bool) -> None:
    """List the preset boards; with BOARD, check that board and print it as JSON.

    Every command takes a file with such JSON as BOARD: edit it to make your own board.
    """
    if board is not None:
        common.echo(common.load_board(board).to_json())
        return

    from engine import Board, preset_names

    boards = [Board.preset(name) for name in preset_names()]
    if as_json:
        common.print_json([_summary(each) for each in boards])
        return
    rows = [_row(each) for each in boards]
    headings = ("name", "pegs", "bins", "pays", "size", "digest")
    widths = [max(map(len, column)) for column in zip(headings, *rows, strict=True)]
    for row in (headings, *rows):
        cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        common.echo("  ".join(cells).rstrip())


def _summary(board: "Board") -> dict[str, object]:
    """A board's row in the list, with the field names of `GET boards`."""
    return {
        "name": board.name,
        "digest": board.digest,
        "pegs": len(board.pegs),
        "bins": board.bins.count,
        "multipliers": list(board.bins.multipliers),
        "width": board.width,
        "height": board.height,
    }


def _row(board: "Board") -> tuple[str, ...]:
    pays = board.bins.multipliers
    return (
        board.name,
        str(len(board.pegs)),
        str(board.bins.count),
        f"{min(pays):g} to {max(pays):g}",
        f"{board.width:.4g} x {board.height:.4g} m",
        board.digest[:16],
    )
