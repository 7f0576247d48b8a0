"""Distance of each contestant's histogram of bins from the true one, and the distance by chance."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.contestants.common import Contestant
from benchmarks.harness.effort import Effort
from benchmarks.harness.report import Section, Table
from plinko.engine import Board, drop_many

SECONDS = 40.0  # longer than any drop on the board takes
RATES = (60, 240)


def histograms(
    section: Section, board: Board, everyone: Sequence[Contestant], effort: Effort
) -> None:
    """Total-variation distance of each histogram from the exact solver's, which has more drops."""
    drops = effort.size(1000, 40)
    truth_drops = effort.size(1_000_000, 10_000)
    zone = board.drop
    share = drop_many(board, range(truth_drops)).histogram / truth_drops
    rng = np.random.default_rng(7)
    xs = rng.uniform(zone.x - zone.jitter, zone.x + zone.jitter, drops)
    samples = rng.multinomial(drops, share / share.sum(), size=2000) / drops
    chance = 0.5 * np.abs(samples - share).sum(axis=1)
    low, middle, high = np.quantile(chance, [0.025, 0.5, 0.975])
    seconds = _seconds(board)
    rows = []
    data: dict[str, Any] = {"drops": drops, "chance": [low, middle, high], "distance": {}}
    for contestant in everyone:
        for rate in RATES if contestant.stepped and not effort.quick else RATES[:1]:
            bins = contestant.bins(board, xs, 1.0 / rate, seconds)
            landed = bins[bins >= 0]
            counts = np.bincount(landed, minlength=board.bins.count)
            distance = 0.5 * float(np.abs(counts / drops - share).sum())
            name = f"{contestant.name} 1/{rate}" if contestant.stepped else contestant.name
            rows.append([name, f"{distance:.4f}", str(drops - len(landed))])
            data["distance"][name] = distance
            effort.step("histograms")
    section.data["histogram"] = data
    section.tables.append(
        Table(
            "Distance of the histogram of bins from the true one",
            ["contestant, dt in s", "total variation", "did not land"],
            rows,
            [
                f"{board.name}, {drops:,} drops each from the same starts, against "
                f"{truth_drops:,} drops of the exact solver. Sampling floor: {drops:,} draws from "
                f"the true histogram itself are {middle:.4f} away (95 %: {low:.4f} to "
                f"{high:.4f}), so a distance in that range shows no error."
            ],
        )
    )


def _seconds(board: Board) -> float:
    """1.25 times the longest duration in a sample of exact drops, at most SECONDS."""
    return min(SECONDS, 1.25 * float(drop_many(board, range(4096)).duration.max()))
