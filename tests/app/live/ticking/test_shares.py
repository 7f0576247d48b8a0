"""A room that costs too much slows down alone: turns in a pass of the ticker."""

from collections import Counter

import pytest

from app.live.ticking.shares import Shares

BUDGET = 0.008


def played(costs: dict[str, float], passes: int) -> tuple[Counter[str], float]:
    """How many turns each room had in so many passes, and what the longest pass took, s."""
    shares = Shares(BUDGET)
    turns: Counter[str] = Counter()
    longest = 0.0
    for passed in range(passes):
        spent = 0.0
        for room in shares.order(costs, "main"):
            if room != "main" and not shares.may_run(room, spent):
                continue
            shares.ran(room, costs[room])
            spent += costs[room]
            turns[room] += 1
        if passed >= len(costs):  # by then what each of them costs is known
            longest = max(longest, spent)
    return turns, longest


def test_rooms_that_cost_little_have_every_turn() -> None:
    costs = {"main": 0.0005, "a": 0.001, "b": 0.002}
    turns, _ = played(costs, 100)
    assert turns == dict.fromkeys(costs, 100)


def test_a_dear_room_waits_and_no_cheap_one_does() -> None:
    cheap = {f"cheap-{n}": 0.0005 for n in range(6)}
    turns, longest = played({"main": 0.001, "dear": 0.007} | cheap, 600)
    assert all(turns[room] >= 560 for room in (*cheap, "main"))
    assert 10 <= turns["dear"] < 300
    assert longest <= 0.5 * BUDGET + 0.007


def test_ten_dear_rooms_share_what_one_of_them_would_have() -> None:
    dear = {f"dear-{n}": 0.008 for n in range(10)}
    turns, longest = played({"main": 0.001} | dear, 600)
    assert turns["main"] == 600
    assert longest <= 0.009 + 1e-9
    assert all(60 <= turns[room] <= 61 for room in dear)


def test_no_room_waits_for_ever() -> None:
    costs = {f"room-{n}": 0.001 * (1 + n) for n in range(30)}
    turns, _ = played(costs, 3000)
    assert min(turns[room] for room in costs) >= 10


def test_who_comes_later_is_owed_nothing_from_before() -> None:
    shares = Shares(BUDGET)
    for _ in range(100):
        shares.order(["old"], "main")
        shares.ran("old", 0.005)
    shares.order(["old", "new"], "main")
    shares.ran("old", 0.005)
    assert shares.order(["old", "new"], "main") == ["old", "new"]  # who is owed a turn goes last
    shares.ran("new", 0.006)
    assert shares.order(["old", "new"], "main") == ["new", "old"]


def test_a_room_that_is_gone_is_forgotten() -> None:
    shares = Shares(BUDGET)
    shares.order(["a", "b"], "main")
    shares.ran("b", 0.5)
    shares.order(["a"], "main")
    shares.ran("b", 0.1)
    shares.order(["b", "a"], "main")
    shares.ran("a", 0.001)
    assert shares.order(["b", "a"], "main") == ["a", "b"]
    assert shares.budget == pytest.approx(BUDGET)
