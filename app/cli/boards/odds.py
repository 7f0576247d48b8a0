"""`plinko odds`: print the presets' returns from recorded drops."""

from typing import TYPE_CHECKING, Final

import click

from plinko.app.cli import common

if TYPE_CHECKING:
    from plinko.engine.payouts.odds import Odds
    from plinko.engine.payouts.record import Record

_HEADS: Final = ("board", "return", "drops", "top award", "hit rate", "volatility", "from aims")


@click.command(name="odds", short_help="Show the presets' returns.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(as_json: bool) -> None:
    """Print each preset's return with its 95 % interval.

    The drops that chose a payout table do not count for its return.
    """
    from plinko.engine.payouts.record import shipped

    (_print_json if as_json else _show)(shipped())


def _print_json(record: "Record") -> None:
    """Print a list of odds per table: from the board's own start, then from each aim."""
    from plinko.engine.board.model import Board
    from plinko.engine.payouts.odds import odds_of

    common.print_json(
        {
            name: [
                odds_of(each, Board.preset(name).bins.multipliers).to_dict()
                for each in counted.fresh(name)
            ]
            for counted in record.values()
            for name in counted.chosen
        }
    )


def _show(record: "Record") -> None:
    """Print the Markdown table that docs/payouts.md contains."""
    from plinko.engine.board.model import Board
    from plinko.engine.payouts.odds import odds_of
    from plinko.engine.payouts.record import still_to_drop, wanted

    common.echo(_row(_HEADS))
    common.echo(_row(["---"] * len(_HEADS)))
    for counted in record.values():
        for name in counted.chosen:
            pays = Board.preset(name).bins.multipliers
            own, *others = (odds_of(each, pays) for each in counted.fresh(name))
            common.echo(_row([f"`{name}`", *_cells(own, others)]))
    needs = wanted(record)
    intervals = sum(len(counted.blocks[-1]) * len(counted.chosen) for counted in record.values())
    drops = [sum(each.drops for each in counted.all()) for counted in record.values()]
    unsettled = sum(each.unsettled_count for counted in record.values() for each in counted.all())
    common.echo(
        f"{sum(drops):,} drops, {unsettled} of them unsettled. "
        f"{intervals - len(needs)} of {intervals} intervals are narrow enough; "
        f"the others need {still_to_drop(needs):,} more drops."
    )


def _row(cells: "list[str] | tuple[str, ...]") -> str:
    return f"| {' | '.join(cells)} |"


def _cells(own: "Odds", others: "list[Odds]") -> list[str]:
    top, chance = own.awards[0]
    return [
        f"{own.returned:.2%} ± {own.doubt:.2%}".replace("%", " %"),
        f"{own.drops:,}",
        f"{top:g}, " + (f"1 in {1 / chance:,.0f}" if chance else "never seen"),
        f"{own.hit_rate:.1%}".replace("%", " %"),
        f"{own.volatility:.2f}",
        ", ".join(f"{each.returned:.2%} ± {each.doubt:.2%}".replace("%", " %") for each in others)
        or "–",
    ]
