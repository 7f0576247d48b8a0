"""`plinko odds` prints the returns that the record of this release proves."""

import json

import pytest

from plinko.app.cli import main
from plinko.engine import Board
from plinko.engine.payouts.odds import odds_of
from plinko.engine.payouts.record import shipped


def test_the_shipped_record_is_shown_in_full_and_not_changed(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["odds"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 3 + sum(len(counted.chosen) for counted in shipped().values())
    assert lines[2].startswith("| `triangle-8` | 99.")
    assert " 0 of them unsettled" in lines[-1]


def test_the_record_as_json_has_the_odds_of_each_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["odds", "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    tables = {name: counted for counted in shipped().values() for name in counted.chosen}
    assert set(shown) == set(tables)
    for name, counted in tables.items():
        pays = Board.preset(name).bins.multipliers
        assert shown[name] == [
            json.loads(json.dumps(odds_of(each, pays).to_dict())) for each in counted.fresh(name)
        ]
