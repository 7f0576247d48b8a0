"""Count drops and solve payout tables for a release: python tools/tables.py count|solve|world.

They change engine/payouts/record.json, which has the counted landings of all presets, and
engine/board/worlds.json. `plinko odds` shows the record.
"""

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Final

import click

from plinko.app.batches.files import write_whole
from plinko.app.cli import common
from plinko.engine import Board, json_text
from plinko.engine.board import presets
from plinko.engine.board import worlds as shipped
from plinko.engine.board.payouts import both_halves
from plinko.engine.payouts import worlds
from plinko.engine.payouts.odds import odds_of
from plinko.engine.payouts.record import (
    Record,
    Wanted,
    counted_on,
    from_text,
    still_to_drop,
    to_text,
    wanted,
)
from plinko.engine.payouts.solve import table_for

ROOT: Final = Path(__file__).resolve().parents[1]
LARGEST: Final = 1 << 24  # bytes of a record; the one of this release has 40 kB

STEP = 500_000
"""Drops between two saves: about ten seconds of one core."""


@click.group()
@click.option(
    "--record",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    default=ROOT / "engine/payouts/record.json",
    help="The record to change.",
)
@click.pass_context
def main(ctx: click.Context, record: Path) -> None:
    """Change the record of counted landings, from which the presets' payout tables are solved."""
    ctx.obj = record


@main.command()
@click.option("--hours", type=click.FloatRange(min=0.0), help="Stop after this many hours.")
@common.workers_options
@click.pass_obj
def count(path: Path, hours: float | None, threads: int | None, cluster: str | None) -> None:
    """Drop balls until every return is known to 0.1 % from the board's start, the cheapest first.

    From each aim it is known to 0.2 % then. The record is saved regularly, and counting can be
    interrupted at any time.
    """
    record, began, dropped = _read(path), time.monotonic(), 0
    with common.workers(cluster, threads) as workers, _asked_to_stop() as stop:
        while needs := wanted(record):
            some = min(STEP, needs[0].drops)
            record = counted_on(record, needs[0], some, workers)
            dropped += some
            _save(path, record)
            spent = time.monotonic() - began
            if stop or (hours is not None and spent >= 3600 * hours):
                break
            _tell(needs, still_to_drop(needs) - some, dropped / spent)
    needs = wanted(record)
    common.echo(
        f"{dropped:,} drops in {(time.monotonic() - began) / 3600:.2f} h; still to do: "
        f"{common.counted(len(needs), 'interval')}, {still_to_drop(needs):,} drops"
    )


@contextmanager
def _asked_to_stop() -> Iterator[list[int]]:
    """Collect signals instead of dying, so that the caller can finish and save its drops."""
    came: list[int] = []

    def note(number: int, _frame: FrameType | None) -> None:
        came.append(number)
        common.echo("stopping after the current drops", err=True)

    before = {each: signal.signal(each, note) for each in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield came
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)


def _tell(needs: list[Wanted], drops: int, rate: float) -> None:
    first = needs[0]
    place = "own start" if first.aim == 0 else f"aim {first.aim}"
    common.echo(
        f"{first.table}, {place}: {first.drops:,} drops to go; in all {len(needs)} intervals, "
        f"{drops:,} drops, {rate:,.0f}/s, {drops / rate / 3600:.1f} h left",
        err=True,
    )


@main.command()
@click.argument("preset")
@click.pass_obj
def solve(path: Path, preset: str) -> None:
    """Print new multipliers of PRESET for engine/board/payouts.py, from all of its counted drops.

    The record notes that these chose the table: only later drops count for its return.
    """
    record, board = _read(path), presets.plain_name(preset)
    if board not in record or preset not in record[board].chosen:
        known = ", ".join(table for counted in record.values() for table in counted.chosen)
        raise click.UsageError(f"{preset!r} is not in the record, which has {known}")
    pays = table_for(Board.preset(preset), record[board].all(), 0.99, presets.risk_of(preset))
    _save(path, {**record, board: record[board].solved_again(preset)})
    common.print_fields({preset: ", ".join(f"{each:g}" for each in pays)})


@main.command()
@click.argument("preset")
@click.option("--tables", type=click.Path(dir_okay=False, path_type=Path),
              default=ROOT / "engine/board/worlds.json", help="The worlds' tables.")  # fmt: skip
@common.workers_options
@click.pass_obj
def world(path: Path, preset: str, tables: Path, threads: int | None, cluster: str | None) -> None:
    """Solve and judge the tables of every risk of a world's PRESET, such as moon-16."""
    variant = presets.VARIANTS.get(preset)
    if variant is None or variant.world == presets.HOUSE or variant.plain != preset:
        raise click.UsageError(f"{preset!r} is not a world's preset, such as moon-16")
    record = _read(path)
    with common.workers(cluster, threads) as workers:
        counted, solved = worlds.solve_world(preset, workers)
    write_whole(tables, worlds.to_text({**shipped.tables(), **solved}).encode())
    _save(path, {**record, preset: counted})
    for table, (_, half) in solved.items():
        odds = odds_of(counted.fresh(table)[0], both_halves(half, variant.rows))
        pays = ", ".join(f"{each:g}" for each in half)
        common.echo(f"{table}: {pays}; return {odds.returned:.2%} ± {odds.doubt:.2%}")


def _read(path: Path) -> Record:
    return from_text(json_text.read_text(path, LARGEST))


def _save(path: Path, record: Record) -> None:
    write_whole(path, to_text(record).encode())


if __name__ == "__main__":
    main()
