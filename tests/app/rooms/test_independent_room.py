"""A room of independent balls without a server: equal commands give equal events and frames."""

from typing import Any

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plinko.app.errors import BallLimitError
from plinko.app.protocol import messages
from plinko.app.rooms.independent import IndependentRoom
from plinko.app.rooms.outcome import landed_of
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.records import DropRow, TableState
from plinko.engine import Board, Label, drop
from plinko.engine.drops.flight import fly
from tests.app.protocol.decoders import decode_snapshot

BOARD = Board.preset("triangle-8")


def room(**options: Any) -> IndependentRoom:
    return IndependentRoom("r", BOARD, **{"tick_rate": 60, "max_balls": 200, **options})


def play(table: IndependentRoom, *, watched: bool = True) -> list[messages.Event]:
    """Tick until nothing moves."""
    events: list[messages.Event] = []
    while table.awake:
        events += table.step(watched=watched)
    return events


def landings(events: list[messages.Event]) -> dict[int, messages.Landed]:
    return {event.ball: event for event in events if isinstance(event, messages.Landed)}


def test_a_landing_names_the_prize_where_its_bin_has_one() -> None:
    prizes = tuple(Label(f"prize {n}") if n % 2 else None for n in range(BOARD.bins.count))
    board = BOARD.replace(bins={"labels": prizes})
    table = IndependentRoom("r", board, tick_rate=60, max_balls=200)
    for seed in range(20):
        table.drop(DropCommand(seed))
    told = {
        landed.bin: msgspec.to_builtins(landed).get("label")
        for landed in landings(play(table)).values()
    }
    assert told == {where: board.bins.label_of(where) for where in told}
    assert set(told.values()) > {None}


def test_watching_changes_nothing_but_what_is_told() -> None:
    watched, alone = room(), room()
    for table in (watched, alone):
        for seed in range(5):
            table.drop(DropCommand(seed))
    heard, unheard = play(watched), play(alone, watched=False)
    assert landings(heard) == landings(unheard)
    assert any(isinstance(event, messages.Contact) for event in heard)
    assert not any(isinstance(event, messages.Contact) for event in unheard)
    assert watched.stats() == alone.stats()


def test_contacts_are_those_of_the_drop_but_for_the_quiet_ones() -> None:
    table = room()
    table.drop(DropCommand(42))
    heard = [event for event in play(table) if isinstance(event, messages.Contact)]
    impacts = drop(BOARD, 42).impacts
    hits = {row["t"] for row in impacts[impacts["kind"] <= 1]}
    assert heard
    assert {contact.t for contact in heard} <= hits
    assert all(contact.speed >= 0.05 for contact in heard)
    for contact in heard:
        assert (contact.tick - 1) / 60 <= contact.t <= contact.tick / 60 + 1e-9


def test_frames_show_where_the_drop_is_at_that_tick() -> None:
    table = room()
    for _ in range(3):
        table.step(watched=True)
    table.drop(DropCommand(42))
    alone = drop(BOARD, 42)
    step_x = (table.extent.x_max - table.extent.x_min) / 65535
    step_y = (table.extent.y_max - table.extent.y_min) / 65535
    while True:
        table.step(watched=True)
        frame = decode_snapshot(table.snapshot(), table.extent, table.velocity_scale)
        if not table.awake:
            break
        (ball,) = frame.balls
        (state,) = alone.states([(frame.tick - 3) / 60])
        assert abs(ball["x"] - state["x"]) <= 0.51 * step_x
        assert abs(ball["y"] - state["y"]) <= 0.51 * step_y
        assert abs(ball["vx"] - state["vx"]) <= 0.51 * table.velocity_scale
        assert abs(ball["vy"] - state["vy"]) <= 0.51 * table.velocity_scale
    assert len(frame.balls) == 0


def test_a_full_room_takes_no_more_until_balls_landed_which_leave_nothing_behind() -> None:
    table = room(max_balls=20)
    for seed in range(20):
        table.drop(DropCommand(seed))
    with pytest.raises(BallLimitError, match="already has 20 balls"):
        table.drop(DropCommand(20))
    assert table.first_message("paths")
    play(table)
    assert not table._bounced
    assert not table._paths
    table.drop(DropCommand(20))


def test_frames_count_the_events_announced_before_them() -> None:
    table, announced = room(), 3
    for seed in range(announced):
        table.drop(DropCommand(seed))
    while table.awake:
        announced += len(table.step(watched=True))
        frame = decode_snapshot(table.snapshot(), table.extent, table.velocity_scale)
        assert frame.seq == announced
    assert table.hello(0.0, messages.Limits(1, 1.0, 1)).seq == announced


def test_hello_names_the_balls_in_flight_and_their_starts() -> None:
    table = room()
    for seed in (11, 12):
        table.drop(DropCommand(seed))
        table.step(watched=False)
    hello = table.hello(5.0, messages.Limits(200, 20.0, 4096))
    starts = [(ball.ball, ball.seed, ball.tick) for ball in hello.balls]
    assert starts == [(0, "11", 0), (1, "12", 1)]
    assert [ball.x for ball in hello.balls] == [drop(BOARD, seed).x_start for seed in (11, 12)]
    assert (hello.tick, hello.server_time) == (2, 5.0)


def test_a_late_tick_shows_the_present_and_tells_every_landing() -> None:
    on_time, late = room(), room()
    told: list[messages.Event] = []
    for seed in range(20):
        on_time.drop(DropCommand(seed, stake=10))
        late.drop(DropCommand(seed, stake=10))
    while on_time.world.tick < 100:
        told += on_time.step(watched=False)
    assert late.advance(100) == told
    assert late.snapshot() == on_time.snapshot()
    assert late.log_world() == on_time.log_world()
    told = play(on_time, watched=False)
    assert late.advance(100_000) == told
    assert (late.histogram, late.log_tick) == (on_time.histogram, on_time.log_tick)
    assert late.log_world() == on_time.log_world(), "a table at rest has the same log at any time"


@given(st.lists(st.integers(1, 90), min_size=1, max_size=8), st.integers(0, 300))
@settings(max_examples=20)
def test_a_table_loaded_from_its_facts_is_the_same(pauses: list[int], later: int) -> None:
    table, facts = room(), list[DropRow]()
    results: set[int] = set()
    for ball, pause in enumerate(pauses):
        fact = table.fact_of(DropCommand(ball), ball)
        facts.append(fact)
        table.enter(fact, fly(BOARD, table.start_of(fact)))
        results |= landings(table.advance(table.world.tick + pause)).keys()
    missed = landings(table.advance(table.world.tick + later))
    sums: dict[int | None, int] = {}
    for fact in facts:
        if fact.ball in results:
            landed = fly(BOARD, table.start_of(fact)).bin
            sums[landed] = sums.get(landed, 0) + 1
    open_ = [fact for fact in facts if fact.ball not in results]
    flying = [(fact, fly(BOARD, table.start_of(fact))) for fact in open_]
    again = room()
    state = TableState(len(facts), facts[-1].tick, table.log_tick, sums, open_)
    found = again.load(state, flying, table.world.tick)
    assert {each.ball: landed_of(BOARD, facts[each.ball], each) for each in found} == missed
    assert again.stats() == table.stats()
    assert again.world.bodies["x"].tolist() == table.world.bodies["x"].tolist()
    if table.awake:
        assert again.log_world() == table.log_world()
    assert play(again, watched=False) == play(table, watched=False)
