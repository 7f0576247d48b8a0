"""Drops as rows of Parquet and CSV: other programs read the values that the engine computed."""

import codecs
import csv
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from plinko.app.batches import rows as rows_module
from plinko.app.batches.files import Draft
from plinko.app.batches.rows import FORMATS, RowWriter
from plinko.app.batches.running import Run
from plinko.app.batches.stopping import Terminated, terminable
from plinko.app.errors import InvalidValueError
from plinko.engine import drop_many
from plinko.engine.batches.block import batch_of
from plinko.engine.batches.job import Job
from plinko.engine.batches.tally import Tally
from plinko.engine.batches.workers import Here
from plinko.engine.parameters import Exact
from tests.app.batches.test_running import Stopping
from tests.engine.batches.open_board import DROPS, OPEN

FIRST = 2**64 - DROPS
JOB = Job(OPEN, Exact(), FIRST, DROPS)


@pytest.mark.parametrize("ending", FORMATS)
def test_rows_are_the_drops_to_the_last_bit(tmp_path: Path, ending: str) -> None:
    import pandas
    import polars

    path = tmp_path / f"drops{ending}"
    run = Run(Tally(JOB))
    with RowWriter(path) as rows:
        run.compute(Here(2), range(3), rows=rows)
        assert not path.exists(), "a file has its name once it is whole"
    expected = drop_many(OPEN, range(FIRST, FIRST + DROPS))
    assert run.tally.digest == expected.digest
    csv = ending == ".csv"
    read = polars.read_csv(path) if csv else polars.read_parquet(path)
    if csv:
        seeds = polars.col("seed").str.strip_prefix("'").cast(polars.UInt64)
        read = read.with_columns(seeds)
    known = expected.columns()
    assert read.columns == list(known)
    for name, column in known.items():
        assert np.array_equal(read[name].to_numpy(), column), name
    if not csv:
        assert pandas.read_parquet(path)["x_end"].to_numpy().tobytes() == expected.x_end.tobytes()
    assert [each.name for each in tmp_path.iterdir()] == [path.name]


def test_a_spreadsheet_reads_csv_as_text_and_rounds_no_seed(tmp_path: Path) -> None:
    with RowWriter(tmp_path / "drops.csv") as rows:
        rows.write(drop_many(OPEN, [0, 2**64 - 1]).columns())
    mark, table = (tmp_path / "drops.csv").read_bytes().partition(b"seed,")[::2]
    assert mark == codecs.BOM_UTF8
    assert [line.partition(",")[0] for line in table.decode().splitlines()[1:]] == [
        "'0",
        "'18446744073709551615",
    ]


def test_an_interrupt_leaves_a_whole_file_of_what_was_done(tmp_path: Path) -> None:
    from pyarrow import parquet

    run = Run(Tally(JOB))
    with RowWriter(tmp_path / "drops.parquet") as rows:
        run.compute(Stopping(1, KeyboardInterrupt), range(3), rows=rows)
    assert parquet.read_table(tmp_path / "drops.parquet").num_rows == run.tally.drops == 65_536


@pytest.fixture(autouse=True)
def interruptible() -> Iterator[None]:
    """Ctrl-C interrupts, even if the tests run in the background, where shells ignore it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


STOPS = {"Ctrl-C": signal.SIGINT, "SIGTERM": signal.SIGTERM}


class Disturbed:
    """Writes the rows of blocks; a signal comes in the middle of the block number `block`."""

    def __init__(self, write: Callable[[Any], Any], number: int, block: int) -> None:
        self._write = write
        self._number = number
        self._left = block

    def __call__(self, rows: Any) -> None:
        self._left -= 1
        self._write(interrupted(rows, self._number) if self._left < 0 else rows)


def interrupted(rows: Any, number: int) -> Iterator[Any]:
    for k, row in enumerate(rows):
        if k == 5:
            signal.raise_signal(number)
        yield row


@pytest.mark.parametrize("number", STOPS.values(), ids=STOPS)
@pytest.mark.parametrize("block", [0, 1, 2])
def test_a_signal_during_writing_leaves_whole_blocks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: signal.Signals, block: int
) -> None:
    """The run stops after the block that was being written, and has counted it."""
    path = tmp_path / "drops.csv"
    made = csv.writer

    def writer(file: Any) -> Any:
        whole = made(file)
        rows = Disturbed(whole.writerows, number, block)
        return SimpleNamespace(writerow=whole.writerow, writerows=rows)

    monkeypatch.setattr(csv, "writer", writer)
    run = Run(Tally(JOB))
    with terminable(), RowWriter(path) as rows:
        run.compute(Here(1), range(3), rows=rows)
    assert run.stopped == number
    assert run.tally.blocks == [(0, block + 1)]
    assert len(path.read_text().splitlines()) == 1 + run.tally.drops
    assert [each.name for each in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("ending", FORMATS)
def test_a_signal_before_the_first_block_leaves_what_was_there(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"drops{ending}"
    for before in (None, "older rows"):
        if before is not None:
            path.write_text(before)
        run = Run(Tally(JOB))
        with RowWriter(path) as rows:
            run.compute(Stopping(0, Terminated), range(3), rows=rows)
        assert run.stopped == signal.SIGTERM
        found = [(each.name, each.read_text()) for each in tmp_path.iterdir()]
        assert found == ([] if before is None else [(path.name, before)])


@pytest.mark.parametrize("number", STOPS.values(), ids=STOPS)
def test_a_signal_at_the_end_waits_until_the_file_has_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: signal.Signals
) -> None:
    path = tmp_path / "drops.csv"
    commit = Draft.commit

    def disturbed(draft: Draft) -> None:
        signal.raise_signal(number)
        commit(draft)

    monkeypatch.setattr(Draft, "commit", disturbed)
    with pytest.raises(KeyboardInterrupt), terminable(), RowWriter(path) as rows:
        rows.write(batch_of(JOB, 2, 1).columns())
    assert len(path.read_text().splitlines()) == 1 + 100
    assert [each.name for each in tmp_path.iterdir()] == [path.name]


def test_an_error_leaves_no_file(tmp_path: Path) -> None:
    with pytest.raises(MemoryError), RowWriter(tmp_path / "drops.csv") as rows:
        Run(Tally(JOB)).compute(Stopping(0, MemoryError), [2], rows=rows)
    assert list(tmp_path.iterdir()) == []


def test_each_block_is_written_at_once_to_keep_memory_flat(tmp_path: Path) -> None:
    """Each block becomes one row group, written as soon as it is computed."""
    from pyarrow import parquet

    path = tmp_path / "drops.parquet"
    with RowWriter(path) as rows:
        for _ in range(5):
            rows.write(batch_of(JOB, 2, 1).columns())
    groups = parquet.ParquetFile(path).metadata
    assert [groups.row_group(k).num_rows for k in range(groups.num_row_groups)] == [100] * 5


@pytest.mark.parametrize("name", ["drops", "drops.xlsx", "drops.parquet.gz"])
def test_another_ending_is_named(tmp_path: Path, name: str) -> None:
    with pytest.raises(InvalidValueError, match=name):
        RowWriter(tmp_path / name)


def test_csv_needs_no_pyarrow_and_parquet_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rows_module, "find_spec", lambda name: None)
    with RowWriter(tmp_path / "drops.csv") as rows:
        rows.write(batch_of(JOB, 2, 1).columns())
    assert len((tmp_path / "drops.csv").read_text("utf-8").splitlines()) == 1 + 100
    with pytest.raises(InvalidValueError, match=r"plinko-sim\[table\]', or write .csv"):
        RowWriter(tmp_path / "drops.parquet")
