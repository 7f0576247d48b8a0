"""Proofs of the drops of a job: block by block, and summed up."""

from collections.abc import Callable
from dataclasses import fields
from functools import partial
from typing import Final

from engine.batches.job import Job
from engine.batches.workers import Workers
from engine.certified.many import Share, certify_many

PART: Final = 256
"""Drops that are asked at a time: 0.1 s where none is proven, some seconds where all are."""


def certify_all(job: Job, workers: Workers, progress: Callable[[int], None] | None = None) -> Share:
    """How many of a job's bins are right; those that are not certain are proven.

    `progress` is called with the number of drops done, now and then.
    """
    total = Share()
    for _, share in workers.compute(partial(_share, job), range(0, job.drops, PART)):
        for each in fields(total):
            setattr(total, each.name, getattr(total, each.name) + getattr(share, each.name))
        if progress is not None:
            progress(total.drops)
    return total


def _share(job: Job, begin: int, _threads: int) -> Share:
    first = job.first + begin
    return certify_many(job.board, range(first, first + min(PART, job.drops - begin)))
