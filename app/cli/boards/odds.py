"""`plinko odds`: print the presets' returns from recorded drops, and drop more for the record."""

import time
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from plinko.app.batches.files import write_whole
from plinko.app.batches.stopping import collected
from plinko.app.cli import common
from plinko.engine import json_text
from plinko.engine.errors import EngineError, RecordError

if TYPE_CHECKING:
    from plinko.engine.batches.workers import Workers
    from plinko.engine.payouts.odds import Odds
    from plinko.engine.payouts.record import Record, Wanted

STEP: Final = 500_000
"""Drops between two saves: about ten seconds of one core."""

LARGEST: Final = 1 << 24
"""Bytes of a record; the one of this release has 40 kB."""

_HEADS: Final = ("board", "return", "drops", "top award", "hit rate", "volatility", "from aims")


@click.command(name="odds", short_help="Show the presets' returns, or count more drops.")
@click.option("--record", type=common.IN, help="A record of drops.  [the one of this release]")
@click.option("--count", is_flag=True, help="Drop more balls; needs --record.")
@click.option(
    "--hours", type=click.FloatRange(min=0.0), help="Stop counting after this many hours."
)
@common.workers_options
@click.option("--solve", metavar="PRESET", help="Solve a new payout table; needs --record.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    record: Path | None,
    count: bool,
    hours: float | None,
    threads: int | None,
    cluster: str | None,
    solve: str | None,
    as_json: bool,
) -> None:
    """Print each preset's return with its 95 % interval.

    The drops that chose a payout table do not count for its return. --count adds drops to the
    record until every return is known to 0.1 % from the board's own start and to 0.2 % from each
    aim, the cheapest first. It saves regularly and can be interrupted at any time. --solve prints
    new multipliers for engine/board/payouts.json and notes in the record that all its drops chose
    them: only later drops count for the new table.
    """
    from plinko.engine.payouts import record as records

    if record is None and (count or solve):
        raise click.UsageError("--count and --solve change a record: name it with --record")
    if as_json and (count or solve):
        raise click.UsageError("--json only shows a record: omit --count and --solve")
    show = _print_json if as_json else _show
    if record is None:
        show(records.shipped())
        return
    found = read_record(record)
    if solve:
        _solve(record, found, solve)
    elif count:
        with common.workers(cluster, threads) as workers:
            _count(record, found, hours, workers)
    else:
        show(found)


def read_record(path: Path) -> "Record":
    from plinko.engine.payouts.record import from_text

    try:
        return from_text(json_text.read_text(path, LARGEST))
    except EngineError as error:
        raise RecordError(f"{path}: {error}", field=error.field) from None


def save_record(path: Path, record: "Record") -> None:
    from plinko.engine.payouts.record import to_text

    write_whole(path, to_text(record).encode())


def _count(path: Path, record: "Record", hours: float | None, workers: "Workers") -> None:
    from plinko.engine.payouts.record import counted_on, still_to_drop, wanted

    began = time.monotonic()
    dropped = 0
    with collected(lambda: common.echo("stopping after the current drops", err=True)) as stop:
        while needs := wanted(record):
            some = min(STEP, needs[0].drops)
            record = counted_on(record, needs[0], some, workers)
            dropped += some
            save_record(path, record)
            spent = time.monotonic() - began
            if stop or (hours is not None and spent >= 3600 * hours):
                break
            _tell(needs, still_to_drop(needs) - some, dropped / spent)
    needs = wanted(record)
    common.echo(
        f"{dropped:,} drops in {(time.monotonic() - began) / 3600:.2f} h; still to do: "
        f"{common.counted(len(needs), 'interval')}, {still_to_drop(needs):,} drops"
    )


def _tell(needs: "list[Wanted]", drops: int, rate: float) -> None:
    first = needs[0]
    place = "own start" if first.aim == 0 else f"aim {first.aim}"
    common.echo(
        f"{first.table}, {place}: {first.drops:,} drops to go; in all {len(needs)} intervals, "
        f"{drops:,} drops, {rate:,.0f}/s, {drops / rate / 3600:.1f} h left",
        err=True,
    )


def _solve(path: Path, record: "Record", name: str) -> None:
    from plinko.engine.board import presets
    from plinko.engine.board.model import Board
    from plinko.engine.payouts.solve import table_for

    board = presets.plain_name(name)
    if board not in record or name not in record[board].chosen:
        known = ", ".join(table for counted in record.values() for table in counted.chosen)
        raise click.UsageError(f"--solve {name!r} is not in the record, which has {known}")
    pays = table_for(Board.preset(name), record[board].all(), 0.99, presets.risk_of(name))
    save_record(path, {**record, board: record[board].solved_again(name)})
    common.print_fields({name: ", ".join(f"{each:g}" for each in pays)})


def _print_json(record: "Record") -> None:
    """Print a list of odds per table: from the board's own start, then from each aim."""
    common.print_json(
        {
            name: [odds.to_dict() for odds in counted.odds(name)]
            for counted in record.values()
            for name in counted.chosen
        }
    )


def _show(record: "Record") -> None:
    """Print the Markdown table that docs/payouts.md contains."""
    from plinko.engine.payouts.record import still_to_drop, wanted

    common.echo(_row(_HEADS))
    common.echo(_row(["---"] * len(_HEADS)))
    for counted in record.values():
        for name in counted.chosen:
            own, *others = counted.odds(name)
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
