"""What is kept of many drops: sums and a running digest, so that memory does not grow."""

import math
from typing import Any

import numpy as np

from engine.board.model import Board
from engine.drops.batch import DropBatch
from engine.drops.digest import OutcomesDigest
from engine.parameters import Solver


class Tally:
    """Counts drops batch after batch; how they were split leaves no trace in it."""

    def __init__(self, board: Board, solver: Solver) -> None:
        self.board = board
        self.solver = solver
        self.drops = 0
        self._histogram = np.zeros(board.bins.count, np.int64)
        self._unsettled = 0
        self._impacts = 0
        self._durations: list[float] = []
        self._digest = OutcomesDigest(board.digest, solver)

    def add(self, batch: DropBatch) -> None:
        """Count the drops of the next seeds."""
        self.drops += len(batch)
        self._histogram += batch.histogram
        self._unsettled += batch.unsettled
        self._impacts += int(batch.impact_count.sum())
        # fsum is exact: the mean has the same bits on every machine.
        self._durations = [math.fsum((*self._durations, *batch.duration))]
        self._digest.add(batch.bin, batch.duration, batch.impact_count, batch.x_end)

    def summary(self) -> dict[str, Any]:
        """What came of at least one drop. Means are over all drops, unsettled ones included."""
        return {
            "board_digest": self.board.digest,
            "drops": self.drops,
            "histogram": self._histogram.tolist(),
            "unsettled": self._unsettled,
            "mean_duration": self._durations[0] / self.drops,
            "mean_impacts": self._impacts / self.drops,
            "digest": self._digest.hexdigest(),
        }
