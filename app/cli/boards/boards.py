"""`plinko boards`: the presets, or one board's JSON."""

from typing import TYPE_CHECKING

import click

from app.cli import common

if TYPE_CHECKING:
    from engine import Board


@click.command(name="boards", short_help="List the preset boards, or print one as JSON.")
@click.argument("board", required=False)
def command(board: str | None) -> None:
    """List the preset boards; with BOARD, check that board and print it as JSON.

    The JSON is a file that every command takes as BOARD: a start for one's own.
    """
    if board is not None:
        click.echo(common.load_board(board).to_json())
        return

    from engine import Board, preset_names

    rows = [_row(Board.preset(name)) for name in preset_names()]
    headings = ("name", "pegs", "bins", "pays", "size", "digest")
    widths = [max(map(len, column)) for column in zip(headings, *rows, strict=True)]
    for row in (headings, *rows):
        cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        click.echo("  ".join(cells).rstrip())


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
