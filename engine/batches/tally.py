"""The result of a job: what came of the blocks that were computed, and of which."""

from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Any, Final

import numpy as np

from engine import merkle
from engine.batches.block import Block
from engine.batches.job import Job, job_of, wanted
from engine.drops.digest import BLOCK
from engine.errors import ParameterError, RecordError

KIND: Final = "plinko-batch"

_HASH: Final = 32  # bytes


class Tally:
    """Sums over blocks of a job; neither their order nor where they came from leaves a trace.

    Memory grows by a hash for each block, some megabytes for a billion drops.
    """

    def __init__(self, job: Job) -> None:
        self.job = job
        self._histogram = np.zeros(job.board.bins.count, np.int64)
        self._unsettled = 0
        self._impacts = 0
        self._duration = Fraction(0)  # exact: the mean has the same bits however blocks came
        self._hashes: dict[int, bytes] = {}

    def add(self, block: Block) -> None:
        """Count a block; ParameterError if it was counted before."""
        self._refuse_twice({block.number})
        self._histogram += np.array(block.histogram)
        self._unsettled += block.unsettled
        self._impacts += block.impacts
        self._duration += Fraction(block.duration)
        self._hashes[block.number] = block.hash

    def merge(self, other: "Tally") -> None:
        """Count other blocks of the same job; ParameterError for another job, or a block twice."""
        ours, theirs = self.job.to_dict(), other.job.to_dict()
        for name, value in ours.items():
            if theirs.get(name) != value:
                raise ParameterError(
                    f"these are no results of one job: {name} is {value!r} in one and "
                    f"{theirs.get(name)!r} in the other",
                    field=name,
                )
        self._refuse_twice(other._hashes.keys() & self._hashes.keys())
        self._histogram += other._histogram
        self._unsettled += other._unsettled
        self._impacts += other._impacts
        self._duration += other._duration
        self._hashes |= other._hashes

    def _refuse_twice(self, numbers: set[int]) -> None:
        for number in sorted(numbers & self._hashes.keys()):
            raise ParameterError(f"block {number} is in both results", field="blocks")

    @property
    def drops(self) -> int:
        """How many were counted."""
        return int(self._histogram.sum()) + self._unsettled

    @property
    def blocks(self) -> list[tuple[int, int]]:
        """Which blocks were counted: each run's first, and the one after its last."""
        runs: list[tuple[int, int]] = []
        for number in sorted(self._hashes):
            if runs and runs[-1][1] == number:
                runs[-1] = (runs[-1][0], number + 1)
            else:
                runs.append((number, number + 1))
        return runs

    @property
    def is_complete(self) -> bool:
        """Whether no block is missing."""
        return len(self._hashes) == self.job.blocks

    def missing(self, begin: int = 0, end: int | None = None) -> Iterator[int]:
        """Numbers of blocks that are not counted when they are asked for, in order."""
        last = self.job.blocks if end is None else end
        return (number for number in range(begin, last) if number not in self._hashes)

    def hash_of(self, number: int) -> bytes | None:
        """The hash of a block's outcomes; None if it was not counted."""
        return self._hashes.get(number)

    @property
    def digest(self) -> str | None:
        """Of the whole batch, 64 hex digits, as `DropBatch.digest`; None while blocks miss."""
        if not self.is_complete:
            return None
        return merkle.root_of([self._hashes[k] for k in range(self.job.blocks)]).hex()

    def summary(self) -> dict[str, Any]:
        """What came of at least one block. Means are over all drops, unsettled ones included."""
        return {
            "board_digest": self.job.board.digest,
            "drops": self.drops,
            "histogram": self._histogram.tolist(),
            "unsettled": self._unsettled,
            "mean_duration": float(self._duration) / self.drops,
            "mean_impacts": self._impacts / self.drops,
            "digest": self.digest,
        }

    def to_dict(self) -> dict[str, Any]:
        """The JSON form, from which `tally_of` goes on: the job, what it covers, sums, hashes."""
        return {
            "kind": KIND,
            **self.job.to_dict(),
            "blocks": [list(run) for run in self.blocks],
            "impacts": self._impacts,
            "duration": str(self._duration),
            **(self.summary() if self._hashes else {"histogram": [], "unsettled": 0}),
            "hashes": [self._hashes[number].hex() for number in sorted(self._hashes)],
        }


def tally_of(form: Any) -> Tally:
    """A tally from its JSON form; RecordError that names what is wrong with it."""
    if not isinstance(form, Mapping) or form.get("kind") != KIND:
        raise RecordError(f"it is no result of `plinko simulate`: its kind is not {KIND!r}")
    tally = Tally(job_of(form))
    try:
        numbers = [n for begin, end in wanted(form, "blocks") for n in range(begin, end)]
        hashes = [bytes.fromhex(each) for each in wanted(form, "hashes")]
        tally._hashes = dict(zip(numbers, hashes, strict=True))
        if numbers:
            tally._histogram += np.array(wanted(form, "histogram"), np.int64)
        tally._unsettled = int(wanted(form, "unsettled"))
        tally._impacts = int(wanted(form, "impacts"))
        tally._duration = Fraction(wanted(form, "duration"))
    except (TypeError, ValueError) as error:
        raise RecordError(f"a malformed result of a batch: {error}") from error
    _check(tally, numbers, form.get("digest"))
    return tally


def _check(tally: Tally, numbers: list[int], digest: Any) -> None:
    """Raise RecordError where counts, blocks, hashes and digest are not of one result."""
    if any(len(each) != _HASH for each in tally._hashes.values()):
        raise RecordError("a hash is not 64 hex digits", field="hashes")
    if len(tally._hashes) != len(numbers) or not all(0 <= n < tally.job.blocks for n in numbers):
        raise RecordError(
            f"blocks {numbers[:4]}… are not some of 0 to {tally.job.blocks - 1}, each once",
            field="blocks",
        )
    drops = sum(len(tally.job.seeds(number)) for number in numbers)
    if drops != tally.drops:
        raise RecordError(
            f"{tally.drops} drops are counted in {len(numbers)} blocks of {BLOCK}, {drops} in all",
            field="histogram",
        )
    if digest != tally.digest:
        raise RecordError(f"digest {digest!r} is not that of the hashes", field="digest")
