"""`plinko odds` extends a record of drops, and prints the returns that it proves."""

import json
from pathlib import Path

import pytest

from plinko.app.cli.boards import odds
from plinko.engine import Board, drop_many
from plinko.engine.board.payouts import TABLES
from plinko.engine.payouts.landings import Landings
from plinko.engine.payouts.odds import odds_of
from plinko.engine.payouts.record import Counted, from_text, shipped, to_text
from tests.app.cli.conftest import Terminal

NAME = "triangle-8"
CHOSE = Landings(None, tuple(drop_many(NAME, range(3000)).histogram.tolist()), 0)


@pytest.fixture
def record(tmp_path: Path) -> Path:
    """A record whose payout table has been fitted to drops but not yet judged by others."""
    path = tmp_path / "record.json"
    judge = Landings(None, (0,) * 9, 0, first=CHOSE.drops)
    path.write_text(to_text({NAME: Counted(((CHOSE,), (judge,)), {NAME: 1})}))
    return path


def test_counting_goes_on_where_it_was_and_is_saved_as_it_goes(
    record: Path, monkeypatch: pytest.MonkeyPatch, plinko: Terminal
) -> None:
    monkeypatch.setattr(odds, "STEP", 60)
    for total in (60, 120):
        code, out, _ = plinko.try_run("odds", "--record", record, "--count", "--hours", 0)
        assert code == 0
        counted = from_text(record.read_text())[NAME]
        assert counted.blocks[0] == (CHOSE,)
        assert counted.fresh(NAME)[0].histogram == tuple(
            drop_many(NAME, range(3000, 3000 + total)).histogram.tolist()
        )
    assert "60 drops in 0.00 h; still to do: 1 interval, " in out
    assert list(record.parent.iterdir()) == [record]


def test_a_table_solved_again_uses_all_counts_and_starts_judging(
    record: Path, plinko: Terminal
) -> None:
    out = plinko.run("odds", "--record", record, "--solve", NAME)
    pays = [float(each) for each in out.split("  ")[-1].split(",")]
    assert odds_of(CHOSE, pays).returned == pytest.approx(0.99, abs=5e-4)
    assert pays[0] == pytest.approx(TABLES[NAME].half[0], rel=0.3)
    assert from_text(record.read_text())[NAME].fresh(NAME)[0].first == CHOSE.drops


def test_the_shipped_record_is_shown_in_full_and_not_changed(plinko: Terminal) -> None:
    lines = plinko.run("odds").splitlines()
    assert len(lines) == 3 + sum(len(counted.chosen) for counted in shipped().values())
    assert lines[2].startswith("| `triangle-8` | 99.")
    assert " 0 of them unsettled" in lines[-1]
    assert "name it with --record" in plinko.refuses("odds", "--count")
    shown = plinko.json("odds")
    tables = {name: counted for counted in shipped().values() for name in counted.chosen}
    assert set(shown) == set(tables)
    for name, counted in tables.items():
        pays = Board.preset(name).bins.multipliers
        assert shown[name] == [
            json.loads(json.dumps(odds_of(each, pays).to_dict())) for each in counted.fresh(name)
        ]
    plinko.refuses("odds", "--json", "--solve", NAME, "--record", "x")
