"""Which servers count as alive, and which take over a failed server's rooms, without I/O."""

from collections import Counter
from collections.abc import Sequence

import msgspec
import pytest

from plinko.app.cluster.membership import HEARTBEAT, LATE, LEASE, Member, Seen, View, order, orphans
from plinko.app.errors import LeaseLostError
from plinko.app.rooms.records import LeaseRow

A, B, C = (Member(f"{name}.1", name, f"http://{name}") for name in "abc")
ROOMS = [f"{number:016x}" for number in range(300)]


def seen(view: View, ages: Sequence[float], *others: Member, me: Member = A) -> None:
    """Heartbeats of `me`, `ages` seconds (by the database's clock) after one another."""
    for age in ages:
        found = [Seen(each, age=0.1, connected=True) for each in others]
        view.look(me, [Seen(me, age, connected=True), *found])


def held(room: str, member: Member) -> LeaseRow:
    return LeaseRow(room, 1, member.holder, member.address, 0.0)


def sure(*others: Member, me: Member = A) -> View:
    view = View()
    seen(view, [0.0, LEASE / 2, LEASE / 2], *others, me=me)
    return view


def test_a_silent_server_is_gone_after_a_whole_lease_of_watching() -> None:
    view = View()
    seen(view, [0.0], B)
    seen(view, [LEASE / 2])
    assert not view.is_gone(B.holder), "it may still find the time to say so"
    seen(view, [LEASE / 2])
    assert view.is_gone(B.holder)
    assert not view.is_gone(A.holder)


def test_a_new_connection_gives_every_server_a_lease_to_report() -> None:
    view = sure(B)
    view.failed()
    assert not view.up
    seen(view, [LEASE / 2, LEASE / 2])
    assert not view.is_gone(B.holder), "PostgreSQL may have been started again"
    assert B.holder in view.members
    seen(view, [LEASE / 2])
    assert view.is_gone(B.holder)


def test_a_slow_heartbeat_extends_no_lease() -> None:
    view = sure(B)
    seen(view, [LEASE - 0.1])
    assert view.is_gone(B.holder)


def test_one_that_was_late_itself_gives_the_others_a_lease() -> None:
    view = sure(B)
    assert view.look(A, [Seen(A, LEASE * 10, connected=True)]) == LEASE * 10
    assert not view.is_gone(B.holder)


def test_a_table_that_was_emptied_gives_the_others_a_lease() -> None:
    view = sure(B)
    view.look(A, [])
    assert not view.is_gone(B.holder)


def test_the_first_beat_and_one_after_a_failure_are_not_late() -> None:
    view = View()
    assert view.look(A, []) == 0.0
    view.failed()
    assert view.look(A, [Seen(A, LEASE * 10, connected=False)]) == 0.0


def test_a_failed_server_stays_failed_while_postgresql_is_down() -> None:
    view = sure()
    view.failed()
    assert view.is_gone(B.holder)


@pytest.mark.parametrize(
    ("age", "connected", "alive"),
    [
        (0.0, True, True),
        (LEASE - 0.1, True, True),
        (LEASE, True, False),
        (HEARTBEAT, False, True),
        (LATE, False, False),
    ],
)
def test_a_server_is_alive_for_a_lease_or_less_when_cut_off(
    age: float, connected: bool, alive: bool
) -> None:
    assert HEARTBEAT < LATE < LEASE
    view = sure(B)
    view.look(A, [Seen(A, HEARTBEAT, connected=True), Seen(B, age, connected)])
    assert view.is_gone(B.holder) is not alive


def test_a_server_has_two_names_and_none_while_it_leaves() -> None:
    view = sure(Member(B.holder, B.name, B.address, leaving=True))
    assert view.named("a") == view.named(A.holder) == A
    assert view.named("b") is None
    assert view.others(A.holder) == []


def claimed(view: View, row: LeaseRow | None, me: Member = A) -> tuple[int, str]:
    """The lease number that `me` may take over, or -1 and the server to ask."""
    try:
        return view.claim("main", row, me), ""
    except LeaseLostError as lost:
        return -1, lost.holder


def test_a_room_without_server_or_of_a_failed_one_is_taken() -> None:
    view = sure(B)
    assert claimed(view, None) == (0, "")
    assert claimed(view, LeaseRow("main", 7, "", "", 0.0)) == (7, "")
    assert claimed(view, held("main", A)) == (1, ""), "it was passed on to this server"
    assert claimed(view, held("main", C)) == (1, "")
    assert claimed(view, held("main", B)) == (-1, B.holder)


def test_no_room_is_taken_while_failures_are_uncertain() -> None:
    view = View()
    seen(view, [0.0])
    assert claimed(view, held("main", C)) == (-1, C.holder)


def test_a_server_that_leaves_takes_nothing_and_names_the_next() -> None:
    me = Member(A.holder, A.name, A.address, leaving=True)
    view = sure(B, me=me)
    for row in (None, held("main", A), held("main", C)):
        assert claimed(view, row, me) == (-1, B.holder)
    assert claimed(sure(me=me), None, me) == (0, ""), "there is no other"


def test_rooms_of_a_server_that_is_gone_spread_over_the_others() -> None:
    assert orphans([held(room, C) for room in ROOMS], [], sure(B)) == set(ROOMS)
    shares = Counter(order(room, [A, B])[0].name for room in ROOMS)
    assert min(shares["a"], shares["b"]) > len(ROOMS) / 3


def test_no_room_of_a_server_that_lives_is_taken() -> None:
    assert orphans([held(room, B) for room in ROOMS], [], sure(B)) == set()


def test_nothing_is_taken_before_failures_are_certain() -> None:
    view = View()
    seen(view, [0.0])
    assert orphans([held("main", C)], ["other"], view) == set()


def test_a_moving_room_without_a_server_is_taken_unless_asleep() -> None:
    assert orphans([], ["moving"], sure()) == {"moving"}


def test_a_server_that_ends_moves_no_rooms_but_its_own() -> None:
    before = {room: order(room, [A, B, C])[0] for room in ROOMS}
    after = {room: order(room, [A, B])[0] for room in ROOMS}
    moved = Counter(before[room].name for room in ROOMS if before[room] != after[room])
    assert set(moved) == {"c"}


def test_a_server_that_leaves_is_offered_no_rooms() -> None:
    view = sure(msgspec.structs.replace(B, leaving=True), C)
    assert {each.name for each in view.takers} == {"a", "c"}
    assert view.others(A.holder) == [C]
