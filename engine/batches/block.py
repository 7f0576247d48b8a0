"""The summary of a block of drops: counts, sums and a hash of all outcomes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plinko.engine.batches.job import Job
from plinko.engine.drops.batch import DropBatch, drop_many
from plinko.engine.drops.digest import block_hash


@dataclass(frozen=True, slots=True)
class Block:
    """The outcomes of block `number` of a job, summed up.

    histogram: drops in each bin. unsettled_count: drops in no bin. impacts: number over all drops.
    duration: correctly rounded sum over all drops, s. hash: of all outcomes, 32 bytes
    (`block_hash`).
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
    return summed(number, [batch_of(job, number, threads)])


def summed(number: int, parts: Sequence[DropBatch]) -> Block:
    """Sum up a block whose drops were computed in `parts`, in the order of their seeds."""
    board, solver = parts[0].board, parts[0].solver
    bins = np.concatenate([each.bin for each in parts])
    durations = np.concatenate([each.duration for each in parts])
    impacts = np.concatenate([each.impact_count for each in parts])
    x_ends = np.concatenate([each.x_end for each in parts])
    return Block(
        number=number,
        histogram=tuple(np.sum([each.histogram for each in parts], axis=0).tolist()),
        unsettled_count=sum(each.unsettled_count for each in parts),
        impacts=int(impacts.sum(dtype=np.int64)),
        duration=math.fsum(durations.tolist()),
        hash=block_hash(board.digest, solver, bins, durations, impacts, x_ends),
    )
