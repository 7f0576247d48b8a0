"""The result of a job: sums over the blocks that were computed, and which blocks these are."""

import re
from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Any, Final

import numpy as np

from plinko.engine.batches.block import Block
from plinko.engine.batches.hashes import BlockHashes, Runs, first_in_both
from plinko.engine.batches.job import Job, job_of, listed, wanted, whole
from plinko.engine.constants import MAX_TIME
from plinko.engine.drops.digest import BLOCK
from plinko.engine.errors import ParameterError, RecordError, shorten
from plinko.engine.exact.outcome import MAX_EVENTS
from plinko.engine.seeding import SEED_LIMIT

KIND: Final = "plinko-batch"

_HASH: Final = re.compile("[0-9a-fA-F]{64}")
_DURATION: Final = re.compile(r"(\d{1,400})(?:/0*([1-9]\d{0,399}))?", re.ASCII)
"""A fraction as long as any sum of float64 numbers."""

_LONGEST: Final = MAX_TIME + 1.0  # s; a drop that does not land ends with the step after MAX_TIME


class Tally:
    """Sums over blocks of a job; they do not depend on the order in which blocks are added.

    Memory grows by one hash per block, up to a limit (`plinko.engine.batches.hashes`).
    """

    def __init__(self, job: Job) -> None:
        self.job = job
        self._histogram = np.zeros(job.board.bins.count, np.int64)
        self._unsettled = 0
        self._impacts = 0
        self._duration = Fraction(0)  # exact, so the mean's bits do not depend on the blocks' order
        self._hashes = BlockHashes(job.blocks)

    def add(self, block: Block) -> None:
        """Add a block; ParameterError if it was already added."""
        if block.number in self._hashes:
            raise _twice(block.number)
        self._histogram += np.array(block.histogram)
        self._unsettled += block.unsettled_count
        self._impacts += block.impacts
        self._duration += Fraction(block.duration)
        self._hashes.add(block.number, block.hash)

    def merge(self, other: "Tally") -> None:
        """Add the blocks of `other`; ParameterError if the jobs differ or a block is in both."""
        ours, theirs = self.job.to_dict(), other.job.to_dict()
        for name, value in ours.items():
            if theirs.get(name) != value:
                raise ParameterError(
                    f"the results are of different jobs: {name} is {shorten(value)} in one and "
                    f"{shorten(theirs.get(name))} in the other",
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
        return int(self._histogram.sum()) + self._unsettled

    @property
    def blocks(self) -> Runs:
        """The blocks that were added."""
        return self._hashes.runs

    def missing(self, begin: int = 0, end: int | None = None) -> Iterator[int]:
        """Yield the numbers of missing blocks in order; each is checked when it is yielded."""
        last = self.job.blocks if end is None else end
        return (number for number in range(begin, last) if number not in self._hashes)

    def hash_of(self, number: int) -> bytes | None:
        """The hash of a block's outcomes; None if it was not added, or was merged with others."""
        return self._hashes.of(number)

    @property
    def digest(self) -> str | None:
        """Digest of the whole batch, as `DropBatch.digest`; None while blocks are missing."""
        root = self._hashes.root
        return None if root is None else root.hex()

    def summary(self) -> dict[str, Any]:
        """The results, if there is a block. Means are over all drops, including unsettled ones."""
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
        """The JSON form, which `tally_of` reads: the job, its computed blocks, sums, hashes."""
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
    """Read a tally from its JSON form; RecordError if it is malformed or inconsistent."""
    if not isinstance(form, Mapping) or form.get("kind") != KIND:
        raise RecordError(f"this is not a result of `plinko simulate`: kind must be {KIND!r}")
    tally = Tally(job_of(form))
    job = tally.job
    runs = [_run_of(run) for run in listed(form, "blocks")]
    _check_runs(runs, job.blocks)
    hashes = [_hash_of(each) for each in listed(form, "hashes")]
    try:
        tally._hashes.fill(runs, hashes)
    except ValueError:
        raise RecordError(
            f"hashes has {len(hashes)} entries, which do not fit the blocks {shorten(runs)}",
            field="hashes",
        ) from None
    histogram = [whole(each, "histogram", job.drops) for each in listed(form, "histogram")]
    bins = job.board.bins.count if runs else 0
    if len(histogram) != bins:
        raise RecordError(
            f"histogram has {len(histogram)} numbers, not {bins}, one for each bin",
            field="histogram",
        )
    tally._histogram[:bins] = histogram
    tally._unsettled = whole(wanted(form, "unsettled"), "unsettled", job.drops)
    tally._impacts = whole(wanted(form, "impacts"), "impacts", job.drops * MAX_EVENTS)
    tally._duration = _duration_of(wanted(form, "duration"), job.drops)
    _check(tally, form.get("digest"))
    return tally


def _run_of(run: Any) -> tuple[int, int]:
    if not isinstance(run, list) or len(run) != 2:
        raise RecordError(
            f"blocks has {shorten(run)}, which is not a pair such as [0, 1]", field="blocks"
        )
    begin, end = (whole(edge, "blocks", SEED_LIMIT) for edge in run)
    return begin, end


def _hash_of(text: Any) -> bytes:
    if not isinstance(text, str) or not _HASH.fullmatch(text):
        raise RecordError(f"hashes has {shorten(text)}, not 64 hex digits", field="hashes")
    return bytes.fromhex(text)


def _duration_of(text: Any, drops: int) -> Fraction:
    """Parse the exact sum of durations in s. Its digits are counted first: they may be any number,
    and an exponent would make a short text a number of a billion digits."""
    fault = RecordError(
        f'duration is {shorten(text)}: it must be a fraction such as "7/2", at most {_LONGEST:g} s '
        f"for each of {drops} drops",
        field="duration",
    )
    found = _DURATION.fullmatch(text) if isinstance(text, str) else None
    if found is None:
        raise fault
    seconds = Fraction(int(found[1]), int(found[2] or 1))
    if seconds > drops * _LONGEST:
        raise fault
    return seconds


def _check_runs(runs: Runs, blocks: int) -> None:
    """Raise RecordError unless `runs` are in order, disjoint and within a job's blocks."""
    edges = [edge for run in runs for edge in run]
    if edges != sorted(edges) or any(not 0 <= begin < end <= blocks for begin, end in runs):
        raise RecordError(
            f"blocks begins with {runs[:4]}: it must have runs of the blocks 0 to {blocks - 1}, in "
            "order and without overlap",
            field="blocks",
        )


def _check(tally: Tally, digest: Any) -> None:
    """Raise RecordError if counts, blocks, hashes and digest contradict each other."""
    job = tally.job
    drops = sum(min(end * BLOCK, job.drops) - begin * BLOCK for begin, end in tally.blocks)
    if drops != tally.drops:
        raise RecordError(
            f"histogram and unsettled count {tally.drops} drops, but the {tally._hashes.count} "
            f"blocks have {drops}",
            field="histogram",
        )
    if digest != tally.digest:
        raise RecordError(
            f"digest is {shorten(digest)}, but the hashes give {tally.digest!r}", field="digest"
        )


def _twice(number: int) -> ParameterError:
    return ParameterError(f"block {number} is in both results: use each only once", field="blocks")
