"""Compute the missing blocks of a job, report the progress, and save the result regularly."""

import signal
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Final

from plinko.app.batches.rows import RowWriter, block_and_rows
from plinko.app.batches.saved import save
from plinko.app.batches.stopping import Terminated, undisturbed
from plinko.engine.batches.tally import Tally
from plinko.engine.batches.workers import Workers

SHARE: Final = 50
"""Saving takes at most one part in SHARE of the time: after a save of 20 ms, none for a second."""

Report = Callable[[int], None]
"""Called with the number of drops counted until now."""


@dataclass
class Run:
    """A growing tally, and the computing time of its blocks in s.

    path: the file in which to save it. stopped: the signal that has interrupted the run. clock: a
    monotonic time in s.
    """

    tally: Tally
    seconds: float = 0.0
    path: Path | None = None
    stopped: signal.Signals | None = None
    clock: Callable[[], float] = field(default=time.perf_counter, repr=False)
    _due: float = 0.0

    def compute(
        self,
        workers: Workers,
        numbers: Iterable[int],
        report: Report | None = None,
        rows: RowWriter | None = None,
    ) -> None:
        """Compute blocks. After an interrupt, tally and rows have the blocks that were finished."""
        before, began = self.seconds, self.clock()
        try:
            work = partial(block_and_rows, self.tally.job, rows is not None)
            for _, (block, found) in workers.compute(work, numbers):
                with undisturbed():
                    if rows is not None and found is not None:
                        rows.write(found)
                    self.tally.add(block)
                    self.seconds = before + self.clock() - began
                    self._save_if_due()
                    if report is not None:
                        report(self.tally.drops)
        except Terminated:
            self.stopped = signal.SIGTERM
        except KeyboardInterrupt:
            self.stopped = signal.SIGINT
        finally:
            with undisturbed():
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
