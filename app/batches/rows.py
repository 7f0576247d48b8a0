"""Write a row for each drop as Parquet or CSV, block by block, so that memory does not grow.

The columns are those of `DropBatch.columns`.
"""

import csv
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path
from types import TracebackType
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from plinko.app.batches.files import Draft, naming
from plinko.app.batches.stopping import undisturbed
from plinko.app.errors import InvalidValueError
from plinko.engine.batches.block import Block, batch_of, summed
from plinko.engine.batches.job import Job

Rows = dict[str, npt.NDArray[np.generic]]
"""Columns by name, each of shape (n,)."""

FORMATS: Final = (".parquet", ".csv")


def block_and_rows(
    job: Job, with_rows: bool, number: int, threads: int
) -> tuple[Block, Rows | None]:
    """Compute a block, and if wanted, a row for each of its drops."""
    batch = batch_of(job, number, threads)
    return summed(number, batch), batch.columns() if with_rows else None


class _Csv:
    """Writes CSV for spreadsheets, which need a byte order mark.

    Floats have enough digits to be read back exactly. A seed gets an apostrophe in front: a
    spreadsheet would round one of more than 15 digits.
    """

    def __init__(self, path: Path, stack: ExitStack) -> None:
        file = stack.enter_context(path.open("w", encoding="utf-8-sig", newline=""))
        self._writer = csv.writer(file)
        self._has_head = False

    def write(self, rows: Rows) -> None:
        if not self._has_head:
            self._writer.writerow(rows)
            self._has_head = True
        columns = (_cells(name, column) for name, column in rows.items())
        self._writer.writerows(zip(*columns, strict=True))


def _cells(name: str, column: npt.NDArray[np.generic]) -> list[object]:
    if name == "seed":
        return [f"'{seed}" for seed in column.tolist()]
    cells = np.where(column, "true", "false") if column.dtype == bool else column
    found: list[object] = cells.tolist()
    return found


class _Parquet:
    def __init__(self, path: Path, stack: ExitStack) -> None:
        self._path = path
        self._stack = stack
        self._writer: Any = None

    def write(self, rows: Rows) -> None:
        import pyarrow  # noqa: PLC0415 - takes half a second, and may not be installed
        from pyarrow import parquet  # noqa: PLC0415

        table = pyarrow.table(rows)
        if self._writer is None:
            made = parquet.ParquetWriter(str(self._path), table.schema)
            self._writer = self._stack.enter_context(made)
        self._writer.write_table(table)


class RowWriter:
    """Writes rows to a draft of the file, which gets its name when it is complete.

    An interrupted run that ends normally leaves a file with the rows of its finished blocks, if it
    has finished any. `write` and the end must not be interrupted; see `undisturbed`.
    """

    def __init__(self, path: Path) -> None:
        if path.suffix not in FORMATS:
            raise InvalidValueError(f"{path.name!r} must end in .parquet or .csv", field="out")
        if path.suffix == ".parquet" and find_spec("pyarrow") is None:
            raise InvalidValueError(
                "Parquet needs pyarrow, which is not installed: pip install "
                "'plinko-sim[table]', or write .csv",
                field="out",
            )
        self._path = path
        self._draft = Draft(path)
        self._open = ExitStack()
        self._has_rows = False

    def __enter__(self) -> "RowWriter":
        made = _Csv if self._path.suffix == ".csv" else _Parquet
        with naming(self._path):
            self._format = made(self._draft.path, self._open)
        return self

    def write(self, rows: Rows) -> None:
        with naming(self._path):
            self._format.write(rows)
        self._has_rows = True

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with undisturbed(), naming(self._path):
            try:
                self._open.close()
                if kind is None and self._has_rows:
                    self._draft.commit()
            finally:
                self._draft.discard()
