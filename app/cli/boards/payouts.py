"""`plinko payouts`: solve a payout table from seeded drops."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from plinko.app.batches.files import write_whole
from plinko.app.cli import common
from plinko.app.cli.boards.odds import read_record, save_record

if TYPE_CHECKING:
    from plinko.engine.batches.workers import Workers
    from plinko.engine.payouts.odds import Odds
    from plinko.engine.payouts.solve import Payouts


@click.command(name="payouts", short_help="Solve the payout table of a board.")
@common.board_argument
@click.option(
    "--return", "returned", type=float, default=0.99, help="Share of the stakes to pay back."
)
@click.option(
    "--risk",
    type=click.Choice(["low", "medium", "high"]),
    default="medium",
    help="How much the outer bins pay compared with the middle ones.",
)
@click.option(
    "--drops", type=common.COUNT, help="Drops from each aim, at most; as many again test the table."
)
@common.workers_options
@click.option("--out", type=common.OUT, help="Write the board with the new table as JSON.")
@click.option(
    "--record",
    type=common.IN,
    help="Solve all tables of a world's preset, such as moon-16, and note the drops in this file.",
)
@click.option("--tables", type=common.OUT, help="The file of all payout tables; needs --record.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    board: str,
    returned: float,
    risk: str,
    drops: int | None,
    threads: int | None,
    cluster: str | None,
    out: Path | None,
    record: Path | None,
    tables: Path | None,
    as_json: bool,
) -> None:
    """Solve the payout table of BOARD for a return such as 0.99.

    The command drops balls until it knows the return from the board's own start to 0.1 % (95 %
    interval); boards with rare bins that pay much need very many. It also counts each aim of a
    player. As many drops of later seeds then measure the return of the new table. Warnings name
    bins with too few hits, and multipliers that fall towards a side.

    With --record and --tables, the same drops solve the tables of every risk of a world's preset,
    for a return of 0.99. As many drops of later seeds judge them. Both files are rewritten:
    engine/payouts/record.json and engine/board/payouts.json.
    """
    from plinko.engine.payouts.solve import MOST, solve_payouts

    if (record is None) != (tables is None):
        raise click.UsageError("--record and --tables belong together: name both files")
    if record is not None and (drops or out or as_json or (returned, risk) != (0.99, "medium")):
        raise click.UsageError(
            "--record solves the tables of every risk for a return of 0.99: omit --return, --risk, "
            "--drops, --out and --json"
        )
    with common.workers(cluster, threads) as workers, common.progress(1, "drops") as progress:
        if record is not None and tables is not None:
            _solve_world(record, tables, board, workers)
            return
        found = solve_payouts(
            common.load_board(board),
            returned=returned,
            risk=risk,
            drops=drops or MOST,
            workers=workers,
            progress=progress,
        )
    if out is not None:
        write_whole(out, f"{json.dumps(found.board.to_dict(), indent=1)}\n".encode())
    if as_json:
        common.print_json(found.to_dict())
    else:
        _show(found)
    for warning in found.warnings:
        common.echo(f"warning: {warning}", err=True)


def _solve_world(record: Path, tables: Path, name: str, workers: "Workers") -> None:
    """Solve and judge the tables of a world's preset; write the drops and the tables."""
    from plinko.engine.board.payouts import TABLES, both_halves
    from plinko.engine.board.presets import HOUSE, VARIANTS
    from plinko.engine.payouts import worlds
    from plinko.engine.payouts.odds import odds_of

    variant = VARIANTS.get(name)
    if variant is None or variant.world == HOUSE or variant.plain != name:
        raise click.UsageError(f"--record needs a world's preset, such as moon-16, not {name!r}")
    known = read_record(record)
    counted, solved = worlds.solve_world(name, workers)
    write_whole(tables, worlds.to_text({**TABLES, **solved}).encode())
    save_record(record, {**known, name: counted})
    for table, (_, half) in solved.items():
        odds = odds_of(counted.fresh(table)[0], both_halves(half, variant.rows))
        pays = ", ".join(f"{each:g}" for each in half)
        common.echo(f"{table}: {pays}; return {_returned(odds)}")


def _show(found: "Payouts") -> None:
    own = found.odds[0]
    common.print_fields(
        {
            "multipliers": ", ".join(f"{pays:g}" for pays in found.multipliers),
            "drops": f"fitted on {found.chosen_by:,}, tested on {found.drops:,} others",
            "return": _returned(own),
            "hit rate": f"{own.hit_rate:.2%}",
            "volatility": f"{own.volatility:.4g}",
            "least return": f"{_returned(found.least)}, {_place(found.least)}",
        }
    )
    common.echo("award     odds")
    for pays, chance in own.awards:
        common.echo(f"{pays:<8g}  " + (f"1 in {1 / chance:,.1f}" if chance else "never seen"))
    for each in found.odds[1:]:
        common.echo(f"{_place(each)}: {_returned(each)}, {each.drops:,} drops")


def _returned(odds: "Odds") -> str:
    return f"{odds.returned:.2%} ± {odds.doubt:.2%}"


def _place(odds: "Odds") -> str:
    return "own start" if odds.aim is None else f"aim {odds.aim:g} m"
