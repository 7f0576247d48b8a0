"""Who counts as alive, and who takes over the rooms of who does not: decisions, without I/O."""

from collections import Counter

import msgspec
import pytest

from app.cluster.membership import BEAT, LATE, LEASE, NEXT, Look, Member, Orphans, View, order
from app.rooms.records import HoldRow

A, B, C = (Member(f"{name}.1", name, f"http://{name}") for name in "abc")
ROOMS = [f"{number:016x}" for number in range(300)]


def seen(view: View, times: list[float], *members: Member, store: str = "s") -> None:
    for now in times:
        view.look(now, Look(store, members))


def held(room: str, member: Member) -> HoldRow:
    return HoldRow(room, 1, member.holder, member.address, 0.0)


def sure(*members: Member) -> View:
    view = View()
    seen(view, [0.0, LEASE / 2, LEASE], *members)
    return view


def test_a_server_that_says_nothing_is_gone_only_once_the_store_was_seen_for_a_lease() -> None:
    view = View()
    seen(view, [0.0], A, B)
    seen(view, [LEASE / 2], A)
    assert not view.is_gone(B.holder), "it may still find the time to say so"
    seen(view, [LEASE], A)
    assert view.is_gone(B.holder)
    assert not view.is_gone(A.holder)


def test_after_the_store_was_away_those_who_lived_have_a_lease_to_say_so_again() -> None:
    view = sure(A, B)
    view.failed()
    assert not view.up
    back = 10 * LEASE
    seen(view, [back, back + LEASE / 2], A)
    assert not view.is_gone(B.holder)
    assert B.holder in view.members
    seen(view, [back + LEASE], A)
    assert view.is_gone(B.holder)


def test_a_store_that_lost_all_it_had_is_one_that_was_away() -> None:
    view = sure(A, B)
    seen(view, [LEASE * 1.2], A, store="another")
    assert not view.is_gone(B.holder)


def test_who_was_gone_before_the_store_went_away_stays_gone() -> None:
    view = sure(A)
    view.failed()
    assert view.is_gone(B.holder)


def said(member: Member, beats: int) -> Member:
    """A server that has said so often that it is alive."""
    return msgspec.structs.replace(member, beats=beats)


def beating(view: View, begin: float, count: int, *silent: Member) -> float:
    """A says that it is alive so often from `begin` on, the others no more; when it did last."""
    for beat in range(count):
        view.look(begin + beat * BEAT, Look("s", (said(A, beat), *silent)))
    return begin + (count - 1) * BEAT


def test_a_silent_server_that_refuses_connections_is_gone_before_its_lease() -> None:
    view = View()
    now = beating(view, 0.0, 7, B)
    assert view.late(now) == [B], "and not the one that is heard of"
    assert not view.is_gone(B.holder)
    view.refused(B)
    assert view.is_gone(B.holder)
    assert B.holder not in view.members
    beating(view, now + BEAT, 1, B)
    assert view.is_gone(B.holder), "its lease is still there, and says nothing new"


def test_whoever_misses_one_beat_is_not_late() -> None:
    view = View()
    now = beating(view, 0.0, 7, B)
    view.look(now, Look("s", (said(A, 7), said(B, 1))))
    view.look(now + BEAT, Look("s", (said(A, 8), said(B, 1))))
    assert BEAT < LATE < 2 * BEAT
    assert view.late(now + BEAT) == []


def test_a_server_that_refused_connections_is_back_once_it_is_heard_of() -> None:
    view = View()
    now = beating(view, 0.0, 7, B)
    view.refused(B)
    view.look(now + BEAT, Look("s", (said(A, 8), said(B, 1))))
    assert not view.is_gone(B.holder)
    assert view.members[B.holder] == said(B, 1)


def test_a_refusal_says_nothing_of_a_server_that_was_heard_of_meanwhile() -> None:
    view = View()
    now = beating(view, 0.0, 7, B)
    view.look(now, Look("s", (said(A, 7), said(B, 1))))
    view.refused(B)
    assert not view.is_gone(B.holder)


def test_nobody_is_late_who_leaves_or_while_the_store_was_not_seen_for_long() -> None:
    leaving = Member(B.holder, B.name, B.address, leaving=True)
    view = View()
    assert view.late(beating(view, 0.0, 7, leaving)) == []
    fresh = View()
    now = beating(fresh, 0.0, 4, B)
    assert now < LEASE
    assert fresh.late(now) == [], "a store that lost all it had knows nobody at first"


def test_a_server_has_two_names_and_none_while_it_leaves() -> None:
    view = sure(A, Member(B.holder, B.name, B.address, leaving=True))
    assert view.named("a") == view.named(A.holder) == A
    assert view.named("b") is None
    assert view.others(A.holder) == []


def test_rooms_of_a_server_that_is_gone_spread_over_the_others() -> None:
    view = sure(A, B)
    rows = [held(room, C) for room in ROOMS]
    shares = {member.name: Orphans().due(rows, [], view, member.holder, LEASE) for member in (A, B)}
    assert sorted(shares["a"] + shares["b"]) == ROOMS, "each is taken by one"
    assert min(map(len, shares.values())) > len(ROOMS) / 3


def test_no_room_of_a_server_that_lives_is_taken() -> None:
    view = sure(A, B)
    assert Orphans().due([held(room, B) for room in ROOMS], [], view, A.holder, LEASE) == []


def test_nothing_is_taken_before_it_is_sure_who_is_gone() -> None:
    view = View()
    seen(view, [0.0], A)
    assert Orphans().due([held("main", C)], ["other"], view, A.holder, 0.0) == []


def test_a_room_that_moves_and_is_nobody_s_is_taken_and_one_that_sleeps_is_not() -> None:
    assert Orphans().due([], ["moving"], sure(A), A.holder, LEASE) == ["moving"]


@pytest.mark.parametrize("room", ROOMS[:10])
def test_a_room_that_the_first_in_its_order_does_not_take_is_the_next_one_s(room: str) -> None:
    view = sure(A, B)
    first, second = order(room, [A, B])
    orphans, rows = Orphans(), [held(room, C)]
    assert orphans.due(rows, [], view, second.holder, 10.0) == []
    assert orphans.waiting
    assert orphans.due(rows, [], view, second.holder, 10.0 + NEXT) == [room]
    assert Orphans().due(rows, [], view, first.holder, 10.0) == [room]
    orphans.due([held(room, first)], [], view, second.holder, 20.0)
    assert not orphans.waiting, "it has a server again"


def test_who_leaves_takes_nothing_over() -> None:
    leaving = Member(B.holder, B.name, B.address, leaving=True)
    rows = [held(room, C) for room in ROOMS]
    assert Orphans().due(rows, [], sure(A, leaving), B.holder, LEASE) == []
    assert Orphans().due(rows, [], sure(A, leaving), A.holder, LEASE) == ROOMS


def test_a_server_that_ends_moves_no_rooms_but_its_own() -> None:
    before = {room: order(room, [A, B, C])[0] for room in ROOMS}
    after = {room: order(room, [A, B])[0] for room in ROOMS}
    moved = Counter(before[room].name for room in ROOMS if before[room] != after[room])
    assert set(moved) == {"c"}
