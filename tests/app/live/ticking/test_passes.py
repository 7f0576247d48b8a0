"""A pass of the ticker shares its time equally; the next begins with the rooms left out."""

import math
from collections import Counter

from hypothesis import given
from hypothesis import strategies as st

from plinko.app.live.ticking.runner import Pass, Turn

BUDGET = 0.008
MAIN = "main"


def run(rooms: list[str], costs: dict[str, float], now: float = 0.0) -> tuple[list[str], float]:
    """Run one pass with these costs of turns; returns the rooms that ran and the end's time."""
    this = Pass(rooms, MAIN, now, BUDGET)
    ran = []
    while (turn := this.next(now)) is not None:
        ran.append(turn.room_id)
        now += costs[turn.room_id]
    return ran, now


def passes(costs: dict[str, float], count: int) -> list[list[str]]:
    """The rooms that ran in each of `count` passes."""
    order = list(costs)
    found = []
    for _ in range(count):
        ran, _ = run(order, costs)
        order = [room for room in order if room not in ran] + ran
        found.append(ran)
    return found


def test_main_runs_first_and_has_as_long_as_it_needs() -> None:
    this = Pass(["a", MAIN, "b"], MAIN, 5.0, BUDGET)
    assert this.next(5.0) == Turn(MAIN, math.inf)
    assert [this.next(9.0), this.next(9.0)] == [Turn("a", 9.0), None]
    assert list(this.coming) == ["b"]


def test_the_rest_of_a_pass_is_shared_by_the_rooms_to_come() -> None:
    this = Pass(["a", "b", "c", "d"], MAIN, 1.0, 8.0)
    assert this.next(1.0) == Turn("a", 3.0)
    assert this.next(3.0) == Turn("b", 5.0), "a took its share"
    assert this.next(3.0) == Turn("c", 6.0), "b took nothing, and the others have more"
    assert this.next(6.0) == Turn("d", 9.0)
    assert this.next(6.0) is None


def test_rooms_that_do_not_fit_are_left_out_evenly() -> None:
    costs = {MAIN: 0.0, "a": 1.0, "b": 0.0}
    assert run(["a", "b"], costs)[0] == ["a"]
    assert run(["b", "a"], costs | {"a": 0.0})[0] == ["b", "a"], "a runs in the next pass"
    costs = {MAIN: 0.001} | {f"room-{n}": 0.003 for n in range(10)}
    turns = Counter(room for ran in passes(costs, 600) for room in ran)
    assert turns.pop(MAIN) == 600
    assert max(turns.values()) - min(turns.values()) <= 1
    assert sum(turns.values()) == 600 * 3


@given(
    st.dictionaries(
        st.sampled_from([MAIN, *"abcdefghij"]), st.floats(0.0, 100.0), min_size=1, max_size=11
    )
)
def test_whatever_rooms_cost_none_waits_longer_than_its_round(costs: dict[str, float]) -> None:
    others = len(set(costs) - {MAIN})
    found = passes(costs, 3 * len(costs))
    for room in costs:
        waited = 0
        for ran in found:
            waited = 0 if room in ran else waited + 1
            assert waited < max(1, others if room != MAIN else 1)


@given(
    st.lists(st.floats(0.0, 0.02), min_size=1, max_size=30),
    st.floats(-1e6, 1e6),
)
def test_a_pass_ends_at_its_budget_unless_a_turn_ends_later(
    costs: list[float], began: float
) -> None:
    rooms = {str(number): cost for number, cost in enumerate(costs)}
    this, now, before = Pass(rooms, MAIN, began, BUDGET), began, began
    while (turn := this.next(now)) is not None:
        before = now
        now += rooms[turn.room_id]
        assert before <= turn.until <= max(before, began + BUDGET) + 1e-9
    assert before <= began + BUDGET
