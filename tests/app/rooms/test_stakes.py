"""Stakes and payouts are whole minor units within their range."""

from fractions import Fraction
from math import floor
from typing import Any

import httpx
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from plinko.app.errors import InvalidValueError
from plinko.app.rooms.independent import IndependentRoom
from plinko.app.rooms.log import verify_log
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.records import TableState
from plinko.app.rooms.stakes import (
    MAX_PAYOUT,
    MAX_STAKE,
    check_payout,
    most_stake,
    parse_stake,
    parse_who,
    payout_of,
)
from plinko.engine import Board, find_draw
from plinko.engine.board.presets import preset_names
from plinko.engine.board.worlds import WORLDS
from plinko.engine.drops.flight import fly
from plinko.engine.payouts.listing import LEAST_RETURN, MOST_RETURN
from plinko.engine.payouts.record import odds_of_record
from tests.app.conftest import QUICK, TINY
from tests.app.live.sessions.test_fair_sessions import bearer, begun_by
from tests.kit.player import playing
from tests.kit.serving import Running


@given(st.integers(0, MAX_STAKE), st.floats(0.0, 1e9))
def test_a_payout_is_the_exact_product_rounded_down_in_64_bits(stake: int, score: float) -> None:
    paid = payout_of(stake, score)
    assert paid == floor(Fraction(repr(score)) * stake)
    assert 0 <= paid < 2**63


def test_a_multiplier_counts_as_it_is_written() -> None:
    paid = [payout_of(*each) for each in ((10, 0.1), (100, 5.6), (3, 0.3), (MAX_STAKE, 1e9))]
    assert paid == [1, 560, 0, 10**18]


@given(st.lists(st.floats(0.0, 1e9), min_size=1, max_size=3))
@example([9007199254740991.0 / 1e9])
@example([1.0, 1e9])
@example([5e-324])
def test_the_largest_stake_is_the_last_that_pays_at_most_2_53(multipliers: list[float]) -> None:
    most = most_stake(multipliers)
    check_payout(most, multipliers)
    assert payout_of(most, max(multipliers)) <= MAX_PAYOUT
    if most < MAX_PAYOUT:
        assert payout_of(most + 1, max(multipliers)) > MAX_PAYOUT
        with pytest.raises(InvalidValueError, match=rf"stake {most + 1} could pay .* {most}$"):
            check_payout(most + 1, multipliers)


_TINY = Board.from_json(QUICK).to_dict()
_BINS = {**_TINY["bins"], "multipliers": [1e9] * len(_TINY["bins"]["multipliers"])}
RICH = {**_TINY, "bins": _BINS}


async def test_a_room_refuses_a_stake_that_could_pay_more_than_readers_keep(
    server: Running, http: httpx.Client
) -> None:
    room = http.post("/api/v1/rooms", json={"board": RICH}).json()["id"]
    most = most_stake([1e9])
    async with playing(server.socket(room)) as player:
        session, token = await begun_by(player)
        shown = bearer(token)
        await player.send(type="drop", session=session, stake=most + 1, ref=1)
        error = await player.until("error")
        body = {"session": session, "stake": MAX_STAKE}
        refused = http.post(f"/api/v1/rooms/{room}/drops", json=body, headers=shown)
        await player.send(type="drop", session=session, stake=most)
        landed = await player.until("landed")
    assert (error["code"], error["ref"]) == ("invalid-value", 1)
    assert error["detail"].startswith(f"stake {most + 1} could pay more than {MAX_PAYOUT}")
    assert (refused.status_code, refused.json()["field"]) == (422, "stake")
    assert str(most) in refused.json()["detail"]
    assert landed["payout"] == most * 10**9


def test_an_invalid_stake_or_mark_is_named() -> None:
    stakes: list[Any] = [-1, MAX_STAKE + 1, 1.5, 1.0, True, "5", [], 10**400]
    marks: list[Any] = ["", "x" * 65, "a\nb", 5, {}]
    for stake in stakes:
        with pytest.raises(InvalidValueError, match=r"stake .* is not a whole number of minor uni"):
            parse_stake(stake)
    for who in marks:
        with pytest.raises(InvalidValueError, match="who "):
            parse_who(who)


def test_a_stake_of_a_ball_in_flight_is_in_its_fact() -> None:
    room = IndependentRoom("r", Board.from_json(TINY), tick_rate=60, max_balls=5)
    fact = room.fact_of(DropCommand(1, stake=250), 0)
    flight = fly(room.board, room.start_of(fact))
    room.enter(fact, flight)
    room.step(watched=False)
    again = IndependentRoom("r", room.board, tick_rate=60, max_balls=5)
    again.load(TableState(1, 0, 0, {}, [fact]), [(fact, flight)], room.world.tick)
    events = [
        event for table in (room, again) for _ in range(200) for event in table.step(watched=False)
    ]
    payouts = [event.payout for event in events if hasattr(event, "payout")]
    (score,) = {event.score for event in events if hasattr(event, "score")}
    assert payouts == [payout_of(250, score)] * 2


async def test_stakes_are_kept_told_and_paid(server: Running, http: httpx.Client) -> None:
    opened = http.post("/api/v1/rooms", json={"board": QUICK}).json()
    room, headers = opened["id"], {"authorization": f"Bearer {opened['token']}"}
    async with playing(server.socket(room)) as player:
        session, token = await begun_by(player)
        await player.send(type="drop", session=session, stake=100, who="ann")
        accepted = await player.until("accepted")
        landed = await player.until("landed")
        await player.send(type="drop", seed=2, stake=0)  # which is no stake
        assert "stake" not in await player.until("accepted")
        assert "payout" not in await player.until("landed")
    assert (accepted["stake"], landed["payout"]) == (100, payout_of(100, landed["score"]))
    body = {"session": session, "stake": 7}
    address = f"/api/v1/rooms/{room}/drops?wait=1"
    reply = http.post(address, json=body, headers=bearer(token)).json()
    assert reply["landed"]["payout"] == payout_of(7, reply["landed"]["score"])
    drops = http.get(f"/api/v1/rooms/{room}/log", headers=headers).json()["drops"]
    assert [(each["stake"], each["who"]) for each in drops] == [(100, "ann"), (0, None), (7, None)]
    assert [each["result"]["payout"] for each in drops[:2]] == [landed["payout"], 0]
    for_all = http.get(f"/api/v1/rooms/{room}/log").json()
    assert [each["who"] for each in for_all["drops"]] == [None] * 3, "marks are the creator's"
    assert verify_log(for_all).ok
    wrong = http.get(f"/api/v1/rooms/{room}/log", headers={"authorization": "Bearer guessed"})
    assert (wrong.status_code, wrong.json()["code"]) == (403, "not-yours")


SIXTEEN = Board.preset("triangle-16").to_dict()


@pytest.mark.parametrize(
    "form",
    [
        {"board": {**TINY, "name": "unsolved"}},
        {"board": {**TINY, "name": "moon-16"}},
        {"board": {**SIXTEEN, "name": "triangle-16 · Moon", "gravity": 1.62}},
        {"board": "galton"},
        {"board": TINY, "mode": "draw", "draw": find_draw(Board.from_json(TINY), [2, 1])},
    ],
    ids=["own", "own with a preset's name", "own gravity", "galton", "draw"],
)
async def test_only_boards_whose_return_is_counted_take_stakes(
    server: Running, http: httpx.Client, form: dict[str, Any]
) -> None:
    room = http.post("/api/v1/rooms", json=form).json()["id"]
    async with playing(server.socket(room)) as player:
        assert player.hello["stakes"] is False
        session, _ = await begun_by(player)
        await player.send(type="drop", session=session, stake=100, ref=1)
        refused = await player.until("error")
        assert (refused["code"], refused["ref"]) == ("invalid-value", 1)
        assert "stake 100: room" in refused["detail"]
        await player.send(type="drop", session=session, ref=2)
        assert "stake" not in await player.until("accepted", ref=2)


def test_every_start_that_takes_stakes_returns_98_5_to_99_5_percent() -> None:
    aimed = 0
    for name in preset_names():
        room = IndependentRoom("1", Board.preset(name), tick_rate=60, max_balls=2)
        for odds in odds_of_record(room.board) if room.takes_stakes else ():
            command = DropCommand(0, aim=odds.aim, stake=100)
            if odds.aim is None:
                room.check_start(command, fair=True)
                assert LEAST_RETURN <= odds.returned <= MOST_RETURN
                continue
            with pytest.raises(InvalidValueError, match=f"stake 100 with aim {odds.aim!r}"):
                room.check_start(command, fair=True)
            room.check_start(DropCommand(0, aim=odds.aim), fair=True)
            aimed += 1
    assert aimed == 4 * 7, "those of triangle-9, triangle-16 and classic"
    # A preset of each world takes stakes.
    for name in ("triangle-16", "classic", *(f"{world}-8-high" for world in WORLDS)):
        assert IndependentRoom("1", Board.preset(name), tick_rate=60, max_balls=2).takes_stakes
