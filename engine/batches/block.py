"""The summary of a block of drops: counts, sums and a hash of all outcomes."""

import math
from dataclasses import dataclass

import numpy as np

from plinko.engine.batches.job import Job
from plinko.engine.drops.batch import DropBatch, drop_many


@dataclass(frozen=True, slots=True)
class Block:
    """The outcomes of block `number` of a job, summed up.

    histogram: drops in each bin. unsettled_count: drops in no bin. impacts: number over all drops.
    duration: correctly rounded sum over all drops, s. hash: of all outcomes, 32 bytes (a block is a
    leaf of a batch's Merkle tree, so this is the digest of its own batch).
    """

    number: int
    histogram: tuple[int, ...]
    unsettled_count: int
    impacts: int
    duration: float
    hash: bytes

    @property
    def drops(self) -> int:
        """Number of drops in the block."""
        return sum(self.histogram) + self.unsettled_count


def batch_of(job: Job, number: int, threads: int) -> DropBatch:
    return drop_many(job.board, job.seeds(number), threads=threads, **job.options)


def block_of(job: Job, number: int, threads: int) -> Block:
    """Compute and sum up the block `number` of a job."""
    return summed(number, batch_of(job, number, threads))


def summed(number: int, batch: DropBatch) -> Block:
    return Block(
        number=number,
        histogram=tuple(batch.histogram.tolist()),
        unsettled_count=batch.unsettled_count,
        impacts=int(batch.impact_count.sum(dtype=np.int64)),
        duration=math.fsum(batch.duration.tolist()),
        hash=bytes.fromhex(batch.digest),
    )
