"""Compute the missing blocks of a job, report the progress, and save the result regularly."""

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Final

from app.batches.rows import Rows, RowWriter, rows_and_block
from app.batches.saved import save
from engine.batches.block import Block, block_of
from engine.batches.tally import Tally
from engine.batches.workers import Workers

SHARE: Final = 50
"""Saving takes at most one part in SHARE of the time: after a save of 20 ms, none for a second."""

Report = Callable[[int], None]
"""Called with the number of drops counted until now."""


@dataclass
class Run:
    """A growing tally, and the s that its blocks took.

    path: the file in which to save it. clock: a monotonic time in s.
    """

    tally: Tally
    seconds: float = 0.0
    path: Path | None = None
    interrupted: bool = False
    clock: Callable[[], float] = field(default=time.perf_counter, repr=False)
    _due: float = 0.0

    def compute(
        self,
        workers: Workers,
        numbers: Iterable[int],
        report: Report | None = None,
        rows: RowWriter | None = None,
    ) -> None:
        """Compute blocks. After an interrupt the tally has the blocks that were finished."""
        before, began = self.seconds, self.clock()
        try:
            for block in self._blocks(workers, numbers, rows):
                self.tally.add(block)
                self.seconds = before + self.clock() - began
                self._save_if_due()
                if report is not None:
                    report(self.tally.drops)
        except KeyboardInterrupt:
            self.interrupted = True
        finally:
            self.save()

    def save(self) -> None:
        if self.path is not None:
            save(self.path, self.tally, self.seconds)

    def _save_if_due(self) -> None:
        began = self.clock()
        if self.path is not None and began >= self._due:
            self.save()
            ended = self.clock()
            self._due = ended + SHARE * (ended - began)

    def _blocks(
        self, workers: Workers, numbers: Iterable[int], rows: RowWriter | None
    ) -> Iterable[Block]:
        job = self.tally.job
        if rows is None:
            return (block for _, block in workers.compute(partial(block_of, job), numbers))
        found = workers.compute(partial(rows_and_block, job), numbers)
        return (_written(rows, made, block) for _, (made, block) in found)


def _written(writer: RowWriter, rows: Rows, block: Block) -> Block:
    """Write the rows of the block, then return it."""
    writer.write(rows)
    return block
