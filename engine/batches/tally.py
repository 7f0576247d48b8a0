"""The result of a job: what came of the blocks that were computed, and of which."""

from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Any, Final

import numpy as np

from engine.batches.block import Block
from engine.batches.hashes import BlockHashes, Runs, first_in_both
from engine.batches.job import Job, job_of, wanted
from engine.drops.digest import BLOCK
from engine.errors import ParameterError, RecordError

KIND: Final = "plinko-batch"

_HASH: Final = 32  # bytes


class Tally:
    """Sums over blocks of a job; neither their order nor where they came from leaves a trace.

    Memory grows by a hash for each block, up to so many (`engine.batches.hashes`).
    """

    def __init__(self, job: Job) -> None:
        self.job = job
        self._histogram = np.zeros(job.board.bins.count, np.int64)
        self._unsettled = 0
        self._impacts = 0
        self._duration = Fraction(0)  # exact: the mean has the same bits however blocks came
        self._hashes = BlockHashes(job.blocks)

    def add(self, block: Block) -> None:
        """Count a block; ParameterError if it was counted before."""
        if block.number in self._hashes:
            raise _twice(block.number)
        self._histogram += np.array(block.histogram)
        self._unsettled += block.unsettled
        self._impacts += block.impacts
        self._duration += Fraction(block.duration)
        self._hashes.add(block.number, block.hash)

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
        both = first_in_both(self.blocks, other.blocks)
        if both is not None:
            raise _twice(both)
        self._histogram += other._histogram
        self._unsettled += other._unsettled
        self._impacts += other._impacts
        self._duration += other._duration
        self._hashes.merge(other._hashes)

    @property
    def drops(self) -> int:
        """How many were counted."""
        return int(self._histogram.sum()) + self._unsettled

    @property
    def blocks(self) -> Runs:
        """Which blocks were counted: each run's first, and the one after its last."""
        return self._hashes.runs

    @property
    def is_complete(self) -> bool:
        """Whether no block is missing."""
        return self._hashes.count == self.job.blocks

    def missing(self, begin: int = 0, end: int | None = None) -> Iterator[int]:
        """Numbers of blocks that are not counted when they are asked for, in order."""
        last = self.job.blocks if end is None else end
        return (number for number in range(begin, last) if number not in self._hashes)

    def hash_of(self, number: int) -> bytes | None:
        """The hash of a block's outcomes; None if it was not counted, or is kept with others."""
        return self._hashes.of(number)

    @property
    def digest(self) -> str | None:
        """Of the whole batch, 64 hex digits, as `DropBatch.digest`; None while blocks miss."""
        root = self._hashes.root
        return None if root is None else root.hex()

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
            **(self.summary() if self._hashes.count else {"histogram": [], "unsettled": 0}),
            "hashes": [each.hex() for each in self._hashes.hashes],
        }


def tally_of(form: Any) -> Tally:
    """A tally from its JSON form; RecordError that names what is wrong with it."""
    if not isinstance(form, Mapping) or form.get("kind") != KIND:
        raise RecordError(f"it is no result of `plinko simulate`: its kind is not {KIND!r}")
    tally = Tally(job_of(form))
    try:
        runs = [(int(begin), int(end)) for begin, end in wanted(form, "blocks")]
        hashes = [bytes.fromhex(each) for each in wanted(form, "hashes")]
        _check_runs(runs, tally.job.blocks)
        tally._hashes.fill(runs, hashes)
        if runs:
            tally._histogram += np.array(wanted(form, "histogram"), np.int64)
        tally._unsettled = int(wanted(form, "unsettled"))
        tally._impacts = int(wanted(form, "impacts"))
        tally._duration = Fraction(wanted(form, "duration"))
    except (TypeError, ValueError) as error:
        raise RecordError(f"a malformed result of a batch: {error}") from error
    _check(tally, hashes, form.get("digest"))
    return tally


def _check_runs(runs: Runs, blocks: int) -> None:
    """Raise RecordError unless these are runs of a job's blocks, in order."""
    edges = [edge for run in runs for edge in run]
    if edges != sorted(edges) or any(not 0 <= begin < end <= blocks for begin, end in runs):
        raise RecordError(
            f"blocks {runs[:4]} are not runs of 0 to {blocks - 1} in order, each once",
            field="blocks",
        )


def _check(tally: Tally, hashes: list[bytes], digest: Any) -> None:
    """Raise RecordError where counts, blocks, hashes and digest are not of one result."""
    if any(len(each) != _HASH for each in hashes):
        raise RecordError("a hash is not 64 hex digits", field="hashes")
    job = tally.job
    drops = sum(min(end * BLOCK, job.drops) - begin * BLOCK for begin, end in tally.blocks)
    if drops != tally.drops:
        raise RecordError(
            f"{tally.drops} drops are counted in {tally._hashes.count} blocks of {BLOCK}, "
            f"{drops} in all",
            field="histogram",
        )
    if digest != tally.digest:
        raise RecordError(f"digest {digest!r} is not that of the hashes", field="digest")


def _twice(number: int) -> ParameterError:
    return ParameterError(f"block {number} is in both results", field="blocks")
