"""Certifies the bins of a job's drops part by part, and sums up how many are right."""

from collections.abc import Callable
from dataclasses import fields
from functools import partial
from typing import Final

from plinko.engine.batches.job import Job
from plinko.engine.batches.workers import Workers
from plinko.engine.certified.many import Share, certify_many

PART: Final = 256
"""Drops in a part: 0.1 s if none needs a proof, a few seconds if all do."""


def certify_all(job: Job, workers: Workers, progress: Callable[[int], None] | None = None) -> Share:
    """Count how many of a job's bins are right, with a proof for each bin that is not certain.

    progress: called now and then with the number of drops done.
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
