"""The tests of the generator accept fair sessions' draws; each rejects a biased generator."""

import hashlib
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from plinko.app.fairness.seeds import drop_seed
from plinko.engine import Board
from tests.app.conftest import TINY
from tests.long import tries
from tools.fairness import chances
from tools.fairness.chances import Outcome
from tools.fairness.generator import (
    DROPS_PER_SESSION,
    LEAST_DROPS,
    LEVEL,
    Words,
    check_generator,
    session_seeds,
)
from tools.fairness.mirror import check_mirror

DOCS = Path(__file__).parents[3] / "docs"
BOARD = Board.preset("triangle-16")


def test_what_sessions_draw_passes() -> None:
    report = check_generator(BOARD, tries(LEAST_DROPS, 100 * LEAST_DROPS))
    assert report.failed == []
    assert report.outside == 0
    assert report.good
    assert len(report.outcomes) == 15


def test_the_seeds_tested_are_those_of_a_session() -> None:
    seeds = session_seeds(3, BOARD)
    assert seeds.shape == (DROPS_PER_SESSION,)
    server = hashlib.sha256(b"plinko conformance server 3").digest()
    client = hashlib.sha256(b"plinko conformance client 3").digest()
    assert int(seeds[7]) == drop_seed(server, client, 7, bytes.fromhex(BOARD.digest))


def _noise(session: int) -> Words:
    return np.random.default_rng(session).integers(0, 2**64, DROPS_PER_SESSION, np.uint64)


def _half_sided(session: int, _: Board) -> Words:
    """Words whose lowest bit is set in 53 of 100 cases."""
    chance = np.random.default_rng([session, 1]).random(DROPS_PER_SESSION)
    return (_noise(session) & ~np.uint64(1)) | (chance < 0.53).astype(np.uint64)


def _poor_byte(session: int, _: Board) -> Words:
    """Words whose fourth byte is never 255, although each bit is set in nearly half of them."""
    words = _noise(session)
    byte = np.uint64(0xFF << 24)
    return np.where(words & byte == byte, words ^ byte, words)


def _each_twice(session: int, _: Board) -> Words:
    return np.repeat(_noise(session)[::2], 2)


def _same_sessions(session: int, _: Board) -> Words:
    return _noise(session // 2)


@pytest.mark.parametrize(
    ("seeds", "name"),
    [
        (_half_sided, "each bit of the seeds is set half the time"),
        (_poor_byte, "byte 3 of the seeds is uniform"),
        (_each_twice, "consecutive drops are independent"),
        (_each_twice, "neighbours are uncorrelated"),
        (_each_twice, "runs of sides are as long as a coin's"),
        (_same_sessions, "consecutive sessions are independent"),
    ],
)
def test_a_generator_with_a_fault_is_named(seeds: Callable[[int, Board], Words], name: str) -> None:
    report = check_generator(BOARD, LEAST_DROPS, seeds)
    assert name in [each.name for each in report.failed]
    assert not report.good


def test_starts_that_scaling_crowds_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def crowded(seeds: Words, x: float, jitter: float) -> npt.NDArray[np.float64]:
        return x + jitter * (np.floor(seeds / 2.0**64 * 256.0) / 128.0 - 1.0)

    monkeypatch.setattr("tools.fairness.generator.start_xs", crowded)
    failed = [each.name for each in check_generator(BOARD, LEAST_DROPS).failed]
    assert {"starts are uniform", "starts scaled to the board are uniform"} <= set(failed)


def test_a_start_out_of_range_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    def wide(seeds: Words, x: float, jitter: float) -> npt.NDArray[np.float64]:
        unit = seeds / 2.0**64 * 2.0 - 1.0
        return x + unit * (jitter if jitter == 1.0 else 1.5 * jitter)

    monkeypatch.setattr("tools.fairness.generator.start_xs", wide)
    report = check_generator(BOARD, LEAST_DROPS)
    assert report.outside == pytest.approx(LEAST_DROPS / 3, rel=0.05)
    assert not report.good


# Statistics.


def test_chances_are_those_of_the_tables() -> None:
    # Chi-square with 255 degrees of freedom exceeds 310.457 with chance 0.01 (two-sided: 0.02).
    counts = np.full(256, 1000)
    counts[3:5] += (394, -394)
    found = chances.chi_square("cells", counts)
    assert found.statistic == pytest.approx(310.457, rel=1e-3)
    assert found.p == pytest.approx(0.02, rel=0.05)
    assert chances.normal("deviate", 1.959964).p == pytest.approx(0.05, rel=1e-6)
    assert chances.even_odds("coins", np.full(64, 500), 1000).p < 1e-9, "too even"


def test_many_tests_together_fail_at_the_level_of_one() -> None:
    def outcomes(*ps: float) -> list[Outcome]:
        return [Outcome(str(p), 0.0, p) for p in ps]

    assert chances.rejected(outcomes(0.004, 0.5, 0.6), LEVEL) == []
    assert [each.p for each in chances.rejected(outcomes(0.5, 0.003, 0.6), LEVEL)] == [0.003]
    assert [each.p for each in chances.rejected(outcomes(0.004, 0.003, 0.6), LEVEL)] == [
        0.003,
        0.004,
    ]


# The mirror.


@pytest.mark.parametrize("name", ["triangle-8", "triangle-16", "classic", "galton"])
def test_a_mirrored_start_ends_in_the_mirror_bit_for_bit(name: str) -> None:
    assert check_mirror(Board.preset(name), tries(200, 20_000)) == []
    # A board with two different sides is noticed.
    pegs = [{"x": 0.1, "y": 1.0, "radius": 0.05}]
    assert len(check_mirror(Board.from_json({**TINY, "pegs": pegs}), 20)) > 1


# The recorded run.


def test_the_recorded_run_is_of_the_shipped_board_and_documented() -> None:
    record = json.loads((DOCS / "conformance.json").read_text())
    assert record["board_digest"] == Board.preset(record["board"]).digest
    assert record["drops"] >= 10**8
    found = [Outcome(**each) for each in record["tests"]]
    fresh = [each.name for each in check_generator(BOARD, 1).outcomes]
    assert [each.name for each in found] == fresh
    assert chances.rejected(found, LEVEL) == record["mirror"]["unlike"] == []
    page = (DOCS / "conformance.md").read_text()
    chance = [each.p for each in found]
    said = f"All {len(found)} tests passed together (p from {min(chance):.2f} to {max(chance):.2f})"
    assert said in page
