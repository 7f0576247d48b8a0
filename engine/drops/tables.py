"""Columns of arrays as tables of Arrow, which pyarrow, polars, pandas, DuckDB and others read."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from plinko.engine.errors import MissingPartError


def arrow_table(columns: Mapping[str, npt.NDArray[np.generic]]) -> Any:
    """A `pyarrow.Table` of columns of equal length; MissingPartError without pyarrow."""
    try:
        import pyarrow  # noqa: PLC0415 - takes half a second, and may not be installed
    except ImportError:
        raise MissingPartError(
            "Arrow needs pyarrow, which is not installed: pip install 'plinko-sim[table]', or "
            "use columns()"
        ) from None
    return pyarrow.table(dict(columns))


def arrow_stream(columns: Mapping[str, npt.NDArray[np.generic]], schema: object) -> object:
    """The table as a PyCapsule, for `__arrow_c_stream__`."""
    return arrow_table(columns).__arrow_c_stream__(schema)
