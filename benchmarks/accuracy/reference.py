"""The true paths on a board: drops of the mpmath oracle, computed by several processes."""

import importlib
import math
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context

import numpy as np
import numpy.typing as npt

from benchmarks.harness import machine
from benchmarks.harness.effort import Effort, MissingError
from plinko.engine import Board
from plinko.engine.constants import KIND_PEG, KIND_WALL

Floats = npt.NDArray[np.float64]

AFTER = (1, 2, 4, 8)
"""Positions are compared midway between these impacts and the next."""

DIGITS = 30
"""Decimal digits of the oracle: a drop loses one or two per impact, and about nine impacts are
compared."""


@dataclass(frozen=True)
class Reference:
    """Drops from xs, shape (n,): all arrays have n rows.

    times: midway after each impact of AFTER, s, shape (n, 4), NaN if a drop has too few impacts;
    positions at these times, m, (n, 4, 2); floor: the position error at these times that one
    rounding of the start causes, m, (n, 4); bins, -1 if the ball does not land; durations in s;
    decidable: whether a program in double precision can know the bin, by the rule of the tests,
    shape (n,).
    """

    board: Board
    xs: Floats
    times: Floats
    positions: Floats
    floor: Floats
    bins: npt.NDArray[np.int64]
    durations: Floats
    decidable: npt.NDArray[np.bool_]


_Row = tuple[list[float], list[tuple[float, float]], list[float], int, float, bool]


def reference(board: Board, drops: int, effort: Effort) -> Reference:
    """Oracle drops of a board, from random starts in the drop zone with a fixed seed."""
    try:
        importlib.import_module("tools.oracle")
    except ImportError as error:
        raise MissingError(f"the oracle needs the bench group: {error}") from error
    zone = board.drop
    xs = np.random.default_rng(2026).uniform(zone.x - zone.jitter, zone.x + zone.jitter, drops)
    rows: list[_Row] = []
    workers = min(machine.cores(), drops)
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        for row in pool.map(partial(_oracle, board.to_json()), xs.tolist()):
            rows.append(row)
            effort.step("oracle")
    times, positions, floor, bins, durations, decidable = zip(*rows, strict=True)
    return Reference(
        board,
        xs,
        np.array(times),
        np.array(positions),
        np.array(floor),
        np.array(bins, np.int64),
        np.array(durations),
        np.array(decidable, np.bool_),
    )


def _oracle(board_json: str, x: float) -> _Row:
    """One oracle drop, rounded to floats."""
    from tools.oracle import golden, oracle_drop

    board = Board.from_json(board_json)
    drop = oracle_drop(board, x, dps=DIGITS)
    rounding = 0.5 * math.ulp(x)
    times, positions, floor = [], [], []
    hits = [i for i, event in enumerate(drop.events) if event.kind in (KIND_PEG, KIND_WALL)]
    for number in AFTER:
        if number >= len(hits):
            times.append(math.nan)
            positions.append((math.nan, math.nan))
            floor.append(math.nan)
            continue
        before, after = drop.events[hits[number - 1]].t, drop.events[hits[number]].t
        time = float((before + after) / 2)
        times.append(time)
        px, py = drop.position_at(time)
        positions.append((float(px), float(py)))
        floor.append(rounding * drop.amplifications[hits[number - 1]])
    where = -1 if drop.bin is None else drop.bin
    decidable = drop.bin is not None and golden.decidable(golden.golden_of(drop, x), board)
    return times, positions, floor, where, float(drop.duration), decidable
