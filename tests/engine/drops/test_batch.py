"""A batch contains the single drop of each seed, however its work is split."""

import math
import threading

import numpy as np
import pytest

from benchmarks.scenes.contact_scenes import scene
from plinko.engine import Board, ParameterError, SeedError, drop, drop_many
from plinko.engine.drops.batch import CHUNK, LEAST_CHUNK, _parts
from plinko.engine.drops.digest import outcomes_digest
from plinko.engine.parameters import SolverName

TRIANGLE = Board.preset("triangle-12")
SOLVERS = ["exact", "stepped"]


def outcomes(board: Board, seeds: object, **options: object) -> bytes:
    """Raw bits of all outcomes, in order."""
    many = drop_many(board, seeds, **options)  # type: ignore[arg-type]
    columns = (many.bin, many.duration, many.impact_count, many.x_end, many.outcome, many.x_start)
    return b"".join(column.tobytes() for column in columns)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("name", ["triangle-8", "triangle-16-high", "classic", "galton"])
def test_a_batch_holds_what_its_drops_give_one_by_one(solver: SolverName, name: str) -> None:
    board = Board.preset(name)
    seeds = [*range(30), 2**63, 2**64 - 1]
    many = drop_many(board, seeds, solver=solver)
    digests = many.digests
    for i, seed in enumerate(seeds):
        one = drop(board, seed, solver=solver)
        assert many.bin[i] == (-1 if one.bin is None else one.bin)
        assert (many.duration[i], many.x_end[i]) == (one.duration, one.x_end)
        assert many.x_start[i] == one.x_start
        assert many.score[i] == one.score
        assert many.impact_count[i] == one.impact_count
        assert digests[i] == one.digest


@pytest.mark.parametrize("solver", SOLVERS)
def test_neither_threads_nor_chunks_change_a_bit(solver: SolverName) -> None:
    count = 3 * CHUNK + 17 if solver == "exact" else CHUNK + 17
    one = drop_many(TRIANGLE, range(count), solver=solver, threads=1)
    for threads in (3, None):
        other = drop_many(TRIANGLE, range(count), solver=solver, threads=threads)
        assert other.digest == one.digest
        assert other.bin.tobytes() == one.bin.tobytes()


@pytest.mark.parametrize("count", [0, 1, LEAST_CHUNK, CHUNK + 1, 20 * CHUNK + 17])
@pytest.mark.parametrize("threads", [1, 2, 7])
def test_threads_take_every_drop_once_and_less_and_less(count: int, threads: int) -> None:
    parts = _parts(count, threads)
    assert [i for part in parts for i in range(part.start, part.stop)] == list(range(count))
    sizes = [part.stop - part.start for part in parts]
    assert sizes == sorted(sizes, reverse=True)
    assert max(sizes, default=0) <= CHUNK
    assert all(size <= LEAST_CHUNK for size in sizes[-1:])


def test_a_batch_split_into_parts_is_the_same_batch() -> None:
    whole = drop_many(TRIANGLE, range(2000))
    parts = [drop_many(TRIANGLE, range(a, b)) for a, b in ((0, 1), (1, 700), (700, 2000))]
    assert whole.digest == outcomes_digest(
        TRIANGLE.digest,
        whole.solver,
        np.concatenate([part.bin for part in parts]),
        np.concatenate([part.duration for part in parts]),
        np.concatenate([part.impact_count for part in parts]),
        np.concatenate([part.x_end for part in parts]),
    )


def test_a_batch_in_another_order_holds_the_same_drops() -> None:
    order = np.random.default_rng(1).permutation(500).astype(np.uint64)
    sorted_, shuffled = drop_many(TRIANGLE, range(500)), drop_many(TRIANGLE, order)
    assert shuffled.duration.tobytes() == sorted_.duration[order.astype(int)].tobytes()
    assert shuffled.bin.tobytes() == sorted_.bin[order.astype(int)].tobytes()
    assert shuffled.digest != sorted_.digest  # the digest depends on the order of the outcomes


def test_seeds_may_come_in_any_form() -> None:
    expected = outcomes(TRIANGLE, range(10))
    for seeds in (
        10,
        np.int64(10),
        iter(range(10)),
        (seed for seed in range(10)),
        dict.fromkeys(range(10)),
        list(range(10)),
        [str(seed) for seed in range(10)],
        np.arange(10),
        np.arange(10, dtype=np.uint64),
        np.arange(10, dtype=np.uint8),
        tuple(range(10)),
    ):
        assert outcomes(TRIANGLE, seeds) == expected
    high = range(2**64 - 3, 2**64)
    assert outcomes(TRIANGLE, high) == outcomes(TRIANGLE, list(high))
    assert outcomes(TRIANGLE, range(9, -1, -3)) == outcomes(TRIANGLE, [9, 6, 3, 0])


def test_an_empty_batch_is_a_batch() -> None:
    none = drop_many(TRIANGLE, [])
    assert len(none) == 0
    assert none.digests == ()
    assert none.histogram.tolist() == [0] * 13
    assert none.digest == drop_many(TRIANGLE, range(0)).digest


def test_what_did_not_land_is_in_no_bin_and_has_its_stake_back() -> None:
    board = scene("shelf").board
    many = drop_many(board, range(5))
    assert many.bin.tolist() == [-1] * 5
    assert many.unsettled.tolist() == [one.unsettled for one in many]
    assert None not in many.unsettled
    assert many.unsettled_count == 5
    assert many.score.tolist() == [1.0] * 5
    assert many.histogram.sum() == 0


def test_the_histogram_counts_every_ball_that_landed() -> None:
    many = drop_many(TRIANGLE, range(3000))
    assert many.histogram.sum() == 3000 - many.unsettled_count
    assert many.histogram.tolist() == [int((many.bin == i).sum()) for i in range(13)]
    assert set(many.unsettled) == {None}


@pytest.mark.parametrize("threads", [1, 2])
def test_progress_rises_to_the_number_of_drops(threads: int) -> None:
    seen: list[int] = []
    drop_many(TRIANGLE, range(2 * CHUNK + 5), threads=threads, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 2 * CHUNK + 5


def test_an_error_in_progress_reaches_the_caller() -> None:
    def refuse(done: int) -> None:
        raise KeyError(done)

    for threads in (1, 2):
        with pytest.raises(KeyError):
            drop_many(TRIANGLE, range(2 * CHUNK), threads=threads, progress=refuse)


@pytest.mark.parametrize("solver", SOLVERS)
def test_two_threads_at_once_do_not_disturb_each_other(solver: SolverName) -> None:
    expected = [drop_many(TRIANGLE, range(a, a + 400), solver=solver).digest for a in (0, 400)]
    found = ["", ""]

    def run(i: int) -> None:
        found[i] = drop_many(TRIANGLE, range(400 * i, 400 * i + 400), solver=solver).digest

    workers = [threading.Thread(target=run, args=(i,)) for i in range(2)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert found == expected


@pytest.mark.parametrize("bad", [[0.0, math.nan], [0.0, math.inf], [0.0, 99.0], [-99.0, 0.0]])
def test_a_bad_start_among_many_is_refused(bad: list[float]) -> None:
    with pytest.raises(ParameterError) as caught:
        drop_many(TRIANGLE, [1, 2], xs=bad)
    assert caught.value.field == "x"


def test_starts_must_be_as_many_as_seeds() -> None:
    with pytest.raises(ParameterError, match=r"xs has shape \(3,\) for 2 seeds"):
        drop_many(TRIANGLE, [1, 2], xs=[0.0, 0.0, 0.0])


@pytest.mark.parametrize("threads", [0, -1, 1.5, "2", True, 1025])
def test_a_bad_number_of_threads_is_refused_with_its_value(threads: object) -> None:
    with pytest.raises(ParameterError) as caught:
        drop_many(TRIANGLE, [1], threads=threads)  # type: ignore[arg-type]
    assert repr(threads) in str(caught.value)
    assert caught.value.field == "threads"


@pytest.mark.parametrize(
    "seeds",
    [
        *(-1, 2**32, True, "12", None, 1.5, {"a"}, [[1, 2]], [1, -1]),
        *([seed] for seed in ("x", 1.5, 2**64, math.nan, True)),
    ],
)
def test_invalid_seeds_are_named(seeds: object) -> None:
    with pytest.raises(SeedError, match="seed"):
        drop_many(TRIANGLE, seeds)  # type: ignore[arg-type]
