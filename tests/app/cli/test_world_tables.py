"""`plinko payouts --record` solves the tables of a world's preset and writes both files."""

import json
from pathlib import Path

import pytest

from plinko.engine.board.payouts import TABLES
from plinko.engine.payouts import worlds
from plinko.engine.payouts.record import from_text
from tests.app.cli.conftest import Terminal

NAMES = ["rubber-8", "rubber-8-low", "rubber-8-high"]


@pytest.fixture(autouse=True)
def few_drops(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in (("LEAST_WORLD", 5_000), ("PRECISE_WORLD", 0.05), ("MOST_OFF", 0.1)):
        monkeypatch.setattr(worlds, name, value)


def test_the_command_writes_the_record_and_the_tables(tmp_path: Path, plinko: Terminal) -> None:
    record, tables = tmp_path / "record.json", tmp_path / "payouts.json"
    record.write_text("{}")
    files = ["--record", str(record), "--tables", str(tables)]
    said = plinko.run("payouts", "rubber-8", *files).splitlines()
    assert [line.split(":")[0] for line in said] == NAMES
    assert list(from_text(record.read_text())) == ["rubber-8"]
    written = json.loads(tables.read_text())
    assert set(written) == set(TABLES)
    for name in set(written) - set(NAMES):
        assert written[name] == [TABLES[name].digest, list(TABLES[name].half)]
    for wrong in (["rubber-8-low", *files], ["triangle-8", *files], ["rubber-8", *files[:2]]):
        plinko.refuses("payouts", *wrong)
    plinko.refuses("payouts", "rubber-8", "--risk", "low", *files)
