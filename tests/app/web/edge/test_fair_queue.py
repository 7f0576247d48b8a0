"""A client with a hundred requests delays another client by one request."""

from hypothesis import given
from hypothesis import strategies as st

from plinko.app.web.edge.intake import FairQueue


@given(st.lists(st.tuples(st.booleans(), st.sampled_from("abc")), max_size=100))
def test_clients_are_served_in_turn_and_each_in_its_own_order(
    acts: list[tuple[bool, str]],
) -> None:
    queue: FairQueue[tuple[str, int]] = FairQueue()
    waiting: dict[str, list[int]] = {client: [] for client in "abc"}
    passed = dict.fromkeys("abc", 0)  # turns of others since a waiting client's last turn
    for number, (comes, client) in enumerate(acts):
        if comes:
            queue.put(client, (client, number))
            waiting[client].append(number)
            continue
        taken = queue.take()
        if taken is None:
            assert not any(waiting.values())
            continue
        whose, which = taken
        assert which == waiting[whose].pop(0)
        for other, waits in waiting.items():
            passed[other] = passed[other] + 1 if waits and other != whose else 0
            assert passed[other] <= 2
