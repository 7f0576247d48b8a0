"""tools/tables.py extends the record of drops, and solves payout tables from it."""

import json
from pathlib import Path

import click
import pytest

from plinko.engine import drop_many
from plinko.engine.board import payouts
from plinko.engine.board import worlds as shipped
from plinko.engine.payouts import worlds
from plinko.engine.payouts.landings import Landings
from plinko.engine.payouts.odds import odds_of
from plinko.engine.payouts.record import Counted, from_text, to_text
from tools import tables

NAME = "triangle-8"
CHOSE = Landings(None, tuple(drop_many(NAME, range(3000)).histogram.tolist()), 0)
NAMES = ["rubber-8", "rubber-8-low", "rubber-8-high"]


@pytest.fixture
def record(tmp_path: Path) -> Path:
    """A record whose payout table has been fitted to drops but not yet judged by others."""
    path = tmp_path / "record.json"
    judge = Landings(None, (0,) * 9, 0, first=CHOSE.drops)
    path.write_text(to_text({NAME: Counted(((CHOSE,), (judge,)), {NAME: 1})}))
    return path


def run(record: Path, *arguments: str) -> None:
    tables.main(["--record", str(record), *arguments], standalone_mode=False)


def test_counting_goes_on_where_it_was_and_is_saved_as_it_goes(
    record: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(tables, "STEP", 60)
    for total in (60, 120):
        run(record, "count", "--hours", "0")
        counted = from_text(record.read_text())[NAME]
        assert counted.blocks[0] == (CHOSE,)
        assert counted.fresh(NAME)[0].histogram == tuple(
            drop_many(NAME, range(3000, 3000 + total)).histogram.tolist()
        )
    assert "60 drops in 0.00 h; still to do: 1 interval, " in capsys.readouterr().out
    assert list(record.parent.iterdir()) == [record]


def test_a_table_solved_again_uses_all_counts_and_starts_judging(
    record: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run(record, "solve", NAME)
    pays = [float(each) for each in capsys.readouterr().out.split("  ")[-1].split(",")]
    assert odds_of(CHOSE, pays).returned == pytest.approx(0.99, abs=5e-4)
    assert pays[0] == pytest.approx(payouts.multipliers(8, "medium")[0], rel=0.3)
    assert from_text(record.read_text())[NAME].fresh(NAME)[0].first == CHOSE.drops


def test_a_world_gets_its_record_and_its_tables(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in (("LEAST_WORLD", 5_000), ("PRECISE_WORLD", 0.05), ("MOST_OFF", 0.1)):
        monkeypatch.setattr(worlds, name, value)
    record, made = tmp_path / "record.json", tmp_path / "worlds.json"
    record.write_text("{}")
    run(record, "world", "rubber-8", "--tables", str(made))
    said = capsys.readouterr().out.splitlines()
    assert [line.split(":")[0] for line in said] == NAMES
    assert list(from_text(record.read_text())) == ["rubber-8"]
    written = json.loads(made.read_text())
    assert set(written) == {*shipped.tables(), *NAMES}
    for name in set(written) - set(NAMES):
        assert written[name] == [shipped.tables()[name].digest, list(shipped.tables()[name].half)]
    for wrong in ("rubber-8-low", "triangle-8"):
        with pytest.raises(click.UsageError, match=f"'{wrong}' is not a world's preset"):
            run(record, "world", wrong, "--tables", str(made))
