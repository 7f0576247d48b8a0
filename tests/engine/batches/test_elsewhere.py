"""Workers find the same payouts, tunings and densities as this process, in any order."""

import pickle
from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import Any

import numpy as np

from plinko.engine import occupancy
from plinko.engine.batches import density
from plinko.engine.batches.certify import certify_all
from plinko.engine.batches.density import Grid, occupancy_by
from plinko.engine.batches.job import Job
from plinko.engine.batches.search import search
from plinko.engine.certified.many import certify_many
from plinko.engine.drops.digest import BLOCK
from plinko.engine.parameters import Exact
from plinko.engine.payouts.landings import more, none_yet
from plinko.engine.payouts.solve import solve_payouts
from tests.engine.batches.open_board import OPEN


class Elsewhere:
    """Workers that pickle their input and output, and finish in the reverse order."""

    at_once = 3

    def compute(
        self, work: Callable[[Any, int], Any], asked: Iterable[Any]
    ) -> Iterator[tuple[Any, Any]]:
        packed, todo = pickle.dumps(work), iter(asked)
        while some := list(islice(todo, self.at_once)):
            for each in reversed(some):
                yield each, pickle.loads(pickle.dumps(pickle.loads(packed)(each, 1)))


def test_landings_of_all_blocks_are_counted() -> None:
    begun = none_yet(OPEN)[0]
    told: list[int] = []
    found = more(OPEN, more(OPEN, begun, 5), 3 * BLOCK + 7, Elsewhere(), told.append)
    assert found == more(OPEN, begun, 3 * BLOCK + 12)
    assert (told[-1], sorted(told)) == (3 * BLOCK + 7, told)


def test_payouts_are_solved_elsewhere() -> None:
    here, there = (
        solve_payouts("triangle-8", drops=3000, workers=workers) for workers in (None, Elsewhere())
    )
    assert there.to_dict() == here.to_dict()


def test_a_search_finds_the_same_whoever_measures() -> None:
    assert list(search(8, 4, 32, Elsewhere())) == list(search(8, 4, 32))


def test_a_density_has_the_same_counts(monkeypatch: Any) -> None:
    monkeypatch.setattr(density, "PART", 150)
    told: list[int] = []
    grid = Grid(left=-1.0, top=0.0, cells_per_metre=20.0, shape=(20, 40))
    found = occupancy_by(Elsewhere(), OPEN, range(5, 505), grid, told.append)
    whole = occupancy(OPEN, range(5, 505), left=-1.0, top=0.0, cells_per_metre=20.0, shape=(20, 40))
    assert np.array_equal(found.counts, whole.counts)
    assert np.array_equal(found.histogram, whole.histogram)
    assert (found.drops, found.step, found.unsettled_count) == (
        whole.drops,
        whole.step,
        whole.unsettled_count,
    )
    assert abs(found.duration - whole.duration) < 1e-9
    assert told[-1] == 500


def test_proofs_are_summed_up() -> None:
    job = Job(OPEN, Exact(), 3, 300)
    told: list[int] = []
    assert certify_all(job, Elsewhere(), told.append) == certify_many(OPEN, range(3, 303))
    assert told[-1] == 300
