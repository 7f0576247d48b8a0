"""A study over boards: the same drops on each of them, as one table."""

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from plinko.engine.board.model import Board
from plinko.engine.drops.batch import Seeds, drop_many, seed_array
from plinko.engine.errors import ParameterError
from plinko.engine.parameters import SolverName


def sweep(
    boards: Mapping[Any, Board | str] | Iterable[Board | str],
    drops: Seeds,
    *,
    solver: SolverName = "exact",
    dt: float | None = None,
    substeps: int | None = None,
    correction: float | None = None,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> dict[str, npt.NDArray[np.generic]]:
    """Drop the same seeds on each board; return columns with a row for each board and drop.

    boards: Boards or presets' names. The column `board` has the mapping's keys, texts or numbers,
    such as the values of a parameter; without a mapping, the boards' names. drops and the options:
    as for `drop_many`. progress: called now and then with the number of drops done on all boards.
    The other columns are those of `DropBatch.columns`. pandas, polars and pyarrow take the result.

    Raises ParameterError if two boards have one name or there is none, and as `drop_many` does.
    """
    named = _named(boards)
    seeds = seed_array(drops)
    columns = []
    for number, board in enumerate(named.values()):
        before = number * len(seeds)
        batch = drop_many(
            board, seeds, solver=solver, dt=dt, substeps=substeps, correction=correction,
            threads=threads, progress=progress and partial(_report, progress, before),
        )  # fmt: skip
        columns.append(batch.columns())
    table: dict[str, npt.NDArray[np.generic]] = {"board": np.repeat([*named], len(seeds))}
    for name in columns[0]:
        table[name] = np.concatenate([each[name] for each in columns])
    return table


def _report(progress: Callable[[int], None], before: int, done: int) -> None:
    progress(before + done)


def _named(
    boards: Mapping[Any, Board | str] | Iterable[Board | str],
) -> dict[Any, Board]:
    """The boards by the values of the column `board`, in their order."""
    if isinstance(boards, Board | str) or not isinstance(boards, Iterable):
        raise ParameterError(
            f"boards is {boards!r:.80}: it must be a mapping, or several boards", field="boards"
        )
    named: dict[Any, Board] = {}
    if isinstance(boards, Mapping):
        named = {key: Board.named(board) for key, board in boards.items()}
    else:
        for board in map(Board.named, boards):
            if board.name in named:
                raise ParameterError(
                    f"two boards are called {board.name!r}: use a mapping with different keys",
                    field="boards",
                )
            named[board.name] = board
    if not named:
        raise ParameterError("boards is empty: there must be at least one", field="boards")
    return named
