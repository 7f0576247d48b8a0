"""A world's tables are solved from one sample, and judged by drops of later seeds."""

import pytest

from plinko.engine import Board, drop_many
from plinko.engine.batches.workers import Here
from plinko.engine.payouts import worlds
from plinko.engine.payouts.odds import odds_of
from plinko.engine.payouts.worlds import solve_world

NAMES = ["rubber-8", "rubber-8-low", "rubber-8-high"]


@pytest.fixture(autouse=True)
def few_drops(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in (("LEAST_WORLD", 5_000), ("PRECISE_WORLD", 0.05), ("MOST_OFF", 0.1)):
        monkeypatch.setattr(worlds, name, value)


def test_the_first_seeds_choose_the_tables_and_as_many_later_ones_judge_them() -> None:
    counted, tables = solve_world("rubber-8", Here())
    (chose,), (judge,) = counted.blocks
    assert (chose.first, judge.first) == (0, chose.drops)
    assert judge.drops == chose.drops >= 5_000
    assert (
        list(judge.histogram)
        == drop_many("rubber-8", range(judge.first, judge.next_seed)).histogram.tolist()
    )
    assert sorted(tables) == sorted(NAMES)
    for name, (digest, half) in tables.items():
        pays = (*half, *half[-2::-1])
        assert odds_of(chose, pays).returned == pytest.approx(0.99, abs=5e-4)
        assert Board.preset(name).replace(bins={"multipliers": pays}).digest == digest


def test_judges_that_disagree_join_the_sample(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a tolerance of 0 all judges disagree; after two rounds the tolerance is large again."""
    rounds = iter([0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0])

    class Tolerance(float):
        def __ge__(self, other: object) -> bool:
            return next(rounds) > 0.0

    monkeypatch.setattr(worlds, "MOST_OFF", Tolerance())
    once, _ = solve_world("rubber-8", Here())
    (chose,), (judge,) = once.blocks
    assert judge.first == chose.drops > 5_000 * 2
