"""A row for each drop, as Parquet or CSV by pyarrow: block by block, so that memory stays flat."""

from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path
from types import TracebackType
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from app.errors import InvalidValueError
from engine.batches.block import Block, batch_of, summed
from engine.batches.job import Job

Rows = dict[str, npt.NDArray[np.generic]]
"""Columns by name, each of shape (n,)."""

COLUMNS: Final = {
    "seed": "seed",
    "bin": "bin",
    "score": "score",
    "duration": "duration",
    "impacts": "impact_count",
    "x_end": "x_end",
}
"""Of a row, and what `DropBatch.to_columns` calls it: duration in s, x_end in m, and the bin is -1
where the ball did not land."""

FORMATS: Final = (".parquet", ".csv")


def rows_and_block(job: Job, number: int, threads: int) -> tuple[Rows, Block]:
    """A block with a row for each of its drops."""
    batch = batch_of(job, number, threads)
    columns = batch.to_columns()
    rows = {name: columns[known] for name, known in COLUMNS.items()}
    return rows, summed(number, [batch])


class RowWriter:
    """Writes rows to a file, which has its name once it is whole, also when it was interrupted."""

    def __init__(self, path: Path) -> None:
        if path.suffix not in FORMATS:
            raise InvalidValueError(f"{path.name!r} ends in neither .parquet nor .csv", field="out")
        if find_spec("pyarrow") is None:
            raise InvalidValueError(
                "rows need pyarrow, which is not installed: pip install 'plinko-server[table]'",
                field="out",
            )
        self._path = path
        self._unfinished = path.with_name(path.name + ".new")
        self._open = ExitStack()
        self._writer: Any = None

    def __enter__(self) -> "RowWriter":
        import pyarrow  # noqa: PLC0415 - half a second, and it may not be installed
        from pyarrow import csv, parquet  # noqa: PLC0415

        kinds = ("u8", "i4", "f8", "f8", "i4", "f8")
        types = [pyarrow.from_numpy_dtype(np.dtype(kind)) for kind in kinds]
        self._schema = pyarrow.schema(list(zip(COLUMNS, types, strict=True)))
        made = csv.CSVWriter if self._path.suffix == ".csv" else parquet.ParquetWriter
        self._writer = self._open.enter_context(made(str(self._unfinished), self._schema))
        return self

    def write(self, rows: Rows) -> None:
        """Append the drops of a block."""
        import pyarrow  # noqa: PLC0415

        self._writer.write_table(pyarrow.table(rows, schema=self._schema))

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._open.close()
        if kind is None:
            self._unfinished.replace(self._path)
        else:
            self._unfinished.unlink()
