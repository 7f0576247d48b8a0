"""The sum of blocks has the same digest in any order, and claims only what it has counted."""

import json
import pickle
import random
from dataclasses import replace
from typing import Any

import pytest

from plinko.engine import (
    Board,
    BoardError,
    ParameterError,
    PlinkoError,
    RecordError,
    concat,
    drop_many,
    merkle,
)
from plinko.engine.batches.block import Block, block_of, summed
from plinko.engine.batches.job import Job, job_of
from plinko.engine.batches.tally import Tally, tally_of
from plinko.engine.batches.workers import Here
from plinko.engine.parameters import Exact, Stepped
from tests.engine.batches.open_board import DROPS, FORM, OPEN

JOB = Job(OPEN, Exact(), 7, DROPS)


@pytest.fixture(scope="module")
def blocks() -> list[Block]:
    return [block_of(JOB, number, 2) for number in range(3)]


def tally_over(blocks: list[Block], *numbers: int) -> Tally:
    tally = Tally(JOB)
    for number in numbers:
        tally.add(blocks[number])
    return tally


def test_a_job_takes_a_preset_s_name_and_is_the_same_in_another_process() -> None:
    job = Job("triangle-8", Exact(), 0, 9)
    assert job == Job(Board.preset("triangle-8"), Exact(), 0, 9)
    assert pickle.loads(pickle.dumps(job)) == job
    assert hash(job) == hash(replace(job, drops=9))
    with pytest.raises(BoardError, match="'triangle-7'"):
        Job("triangle-7", Exact(), 0, 9)


def test_blocks_in_any_order_are_the_batch(blocks: list[Block]) -> None:
    whole = drop_many(OPEN, range(7, 7 + DROPS))
    summaries = [tally_over(blocks, *order).summary() for order in ((0, 1, 2), (2, 0, 1))]
    assert summaries[0] == summaries[1]
    assert summaries[0]["digest"] == whole.digest
    assert summaries[0]["histogram"] == whole.histogram.tolist()
    assert summaries[0]["mean_impacts"] == whole.impact_count.mean()
    assert summaries[0]["mean_duration"] == pytest.approx(whole.duration.mean(), rel=1e-14)


def test_the_digest_is_the_merkle_root_over_separate_blocks(blocks: list[Block]) -> None:
    whole = drop_many(OPEN, range(7, 7 + DROPS))
    left = merkle.node_hash(blocks[0].hash, blocks[1].hash)
    assert whole.digest == merkle.node_hash(left, blocks[2].hash).hex()
    assert whole[65_536 : 2 * 65_536].digest == blocks[1].hash.hex()


def test_a_block_computed_in_parts_is_the_same(blocks: list[Block]) -> None:
    seeds = JOB.seeds(2)
    parts = [drop_many(OPEN, seeds[a:b], threads=1) for a, b in ((0, 1), (1, 60), (60, 100))]
    assert summed(2, concat(parts)) == blocks[2]


@pytest.mark.parametrize("first", [(0,), (1,), (2,), (0, 2)])
def test_parts_of_a_batch_merge_to_the_whole(blocks: list[Block], first: tuple[int, ...]) -> None:
    rest = [number for number in range(3) if number not in first]
    one, other = tally_over(blocks, *first), tally_over(blocks, *rest)
    assert one.digest is None
    assert [*one.missing()] == rest
    read = tally_of(json.loads(json.dumps(one.to_dict())))
    read.merge(other)
    assert read.to_dict() == tally_over(blocks, 0, 1, 2).to_dict()


def test_a_block_counts_once(blocks: list[Block]) -> None:
    tally = tally_over(blocks, 0, 1)
    with pytest.raises(ParameterError, match="block 1 "):
        tally.add(blocks[1])
    with pytest.raises(ParameterError, match="block 0 "):
        tally.merge(tally_over(blocks, 2, 0))
    assert tally.to_dict() == tally_over(blocks, 0, 1).to_dict()


@pytest.mark.parametrize(
    ("other", "field"),
    [
        (Job(OPEN, Exact(), 8, DROPS), "seed"),
        (Job(OPEN, Exact(), 7, DROPS + 1), "asked"),
        (Job(OPEN, Exact(), 7, DROPS, 0.05), "aim"),
        (Job(OPEN, Stepped(), 7, DROPS), "solver"),
    ],
)
def test_results_of_two_jobs_do_not_merge(other: Job, field: str) -> None:
    with pytest.raises(ParameterError) as caught:
        Tally(JOB).merge(Tally(other))
    assert caught.value.field == field


@pytest.mark.parametrize("solver", [Exact(), Stepped(0.01, 2)])
@pytest.mark.parametrize("aim", [None, 0.05])
def test_a_job_comes_back_from_its_json(solver: Exact | Stepped, aim: float | None) -> None:
    job = Job(OPEN, solver, 2**64 - 10, 10, aim)
    assert job_of(json.loads(json.dumps(job.to_dict()))) == job


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"kind": "plinko-room"}, "plinko-batch"),
        ({"physics_version": 3}, "physics_version is 3"),
        ({"board_digest": "0" * 64}, "board_digest"),
        ({"board": FORM | {"drag": 0.25}}, "board_digest"),
        ({"asked": "many"}, "'many'"),
        ({"solver": "none"}, "'none'"),
        ({"blocks": [[0, 2]]}, "do not fit the blocks"),
        ({"blocks": [[0, 1], [0, 1], [2, 3]]}, "without overlap"),
        ({"blocks": [[0, 2], [3, 4]]}, "without overlap"),
        ({"histogram": [1, 2, 3]}, "count 6 drops"),
        ({"hashes": ["00"] * 3}, "64 hex digits"),
        ({"hashes": ["0" * 64] * 3}, "digest"),
        ({"duration": "long"}, "long"),
        ({"duration": "1/0"}, "'1/0'"),
        ({"duration": "1e9999999999"}, "1e9999999999"),
        ({"duration": "-1"}, "'-1'"),
        ({"duration": f"{10**399}"}, "at most"),
        ({"duration": "9" * 10**6}, "at most"),
        ({"duration": 5}, "is 5"),
        ({"impacts": 10**400}, "impacts is 1000"),
        ({"impacts": 10**5000}, "thousands of digits"),
        ({"impacts": -1}, "impacts is -1"),
        ({"unsettled": True}, "unsettled is True"),
        ({"unsettled": 1.0}, "unsettled is 1.0"),
        ({"asked": 10**400}, "asked is 1000"),
        ({"asked": True}, "asked is True"),
        ({"seed": 10**400}, "seed 1000"),
        ({"histogram": [DROPS]}, "histogram has 1 numbers"),
        ({"histogram": [-5, DROPS, 5]}, "histogram is -5"),
        ({"histogram": [10**400, 0, 0]}, "histogram is 1000"),
        ({"histogram": "012"}, "must be a list"),
        ({"blocks": [[0.5, 3]]}, "blocks is 0.5"),
        ({"blocks": [[0, 10**400]]}, "blocks is 1000"),
        ({"blocks": [0, 3]}, "not a pair"),
        ({"blocks": None}, "must be a list"),
        ({"hashes": [5]}, "hashes has 5"),
        ({"digest": "f" * 10**6}, "but the hashes give"),
        ({"dt": 0.1}, "needs solver 'stepped'"),
        ({"aim": "left"}, "left"),
    ],
)
def test_a_result_that_is_not_one_is_refused(
    blocks: list[Block], changes: dict[str, Any], said: str
) -> None:
    with pytest.raises(RecordError, match=said) as it:
        tally_of(tally_over(blocks, 0, 1, 2).to_dict() | changes)
    assert len(str(it.value)) < 400


def test_a_result_that_lacks_a_field_is_refused(blocks: list[Block]) -> None:
    form = tally_over(blocks, 0, 1, 2).to_dict()
    means = {"drops", "mean_duration", "mean_impacts", "aim"}
    for name in form.keys() - means:
        with pytest.raises(RecordError):
            tally_of({key: value for key, value in form.items() if key != name})


@pytest.mark.parametrize("bad", [(0, 0, None), (-1, 5, None), (2**64 - 4, 5, None), (0, 1, 9.0)])
def test_a_job_that_cannot_be_is_refused(bad: tuple[int, int, float | None]) -> None:
    first, drops, aim = bad
    with pytest.raises(PlinkoError):
        Job(OPEN, Exact(), first, drops, aim)


def test_this_process_computes_lazily_and_in_order() -> None:
    asked = iter(range(10))
    found = Here(threads=3).compute(lambda each, threads: each * threads, asked)
    assert [next(found), next(found)] == [(0, 0), (1, 3)]
    assert next(asked) == 2


@pytest.mark.parametrize("size", [0, 1, 2, 3, 5, 8, 13, 64, 100])
def test_the_root_of_leaves_is_that_of_a_log_that_grew(size: int) -> None:
    leaves = [random.Random(k).randbytes(9) for k in range(size)]
    log: dict[tuple[int, int], bytes] = {}

    def lookup(level: int, number: int) -> bytes:
        return log[level, number]

    for k, leaf in enumerate(leaves):
        log.update(merkle.added(k, leaf, lookup))
    hashes = [merkle.leaf_hash(leaf) for leaf in leaves]
    assert merkle.root_of(hashes) == merkle.root(size, lookup)
