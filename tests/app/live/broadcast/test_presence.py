"""Presence: the server sends visitors' names seldom, and only some of a crowd."""

from collections.abc import Callable
from typing import Any

import msgspec
import pytest

from plinko.app.live.broadcast.hub import Client, Mailbox
from plinko.app.live.broadcast.presence import MOST_NAMED, Presence
from plinko.app.protocol import messages
from plinko.app.protocol.visitors import Appearance
from tests.app.conftest import TINY
from tests.app.protocol.test_seeds import Ear, Watched
from tests.kit.player import playing
from tests.kit.serving import Running

ACCEPTED = messages.Accepted(ball=0, seed="1", x=0.0, explicit_x=False, tick=1)


class Salon:
    """Rooms with visitors, and a clock that the test sets."""

    def __init__(self) -> None:
        self.now = 100.0
        self.ears: dict[int, Ear] = {}
        self._due: list[tuple[float, Callable[[], None]]] = []
        self.presence = Presence(lambda: self.now, self._later)

    def _later(self, seconds: float, call: Callable[[], None]) -> None:
        self._due.append((self.now + seconds, call))

    def appear(
        self, number: int, name: str | None = None, room: str = "r", **more: Any
    ) -> messages.Presence:
        client = Client(number, self.ears.setdefault(number, Ear()), Mailbox(9, 9999), 1.0)
        return self.presence.appear(room, client, Appearance(name, **more))

    def wait(self, seconds: float) -> None:
        until = self.now + seconds
        while self._due and min(self._due, key=lambda due: due[0])[0] <= until:
            first = min(self._due, key=lambda due: due[0])
            self._due.remove(first)
            self.now = max(self.now, first[0])
            first[1]()
        self.now = until

    @property
    def idle(self) -> bool:
        return not self._due


def names(event: dict[str, Any]) -> list[str | None]:
    return [visitor.get("name") for visitor in event["visitors"]]


def test_a_visitor_learns_of_others_at_once_and_they_soon() -> None:
    salon = Salon()
    first = salon.appear(7, "Ada")
    assert (first.you, first.here) == (1, 1)
    salon.wait(5.0)
    second = salon.appear(8)
    assert (second.you, second.here, [v.visitor for v in second.visitors]) == (2, 2, [1, 2])
    salon.wait(0.0)
    told = salon.ears[7].events[-1]
    assert told == {
        "type": "presence",
        "here": 2,
        "visitors": [{"visitor": 1, "name": "Ada"}, {"visitor": 2}],
    }
    assert salon.appear(7, "Ada L.").you == 1, "a name may be changed, and the number stays"
    salon.wait(2.0)
    assert names(salon.ears[7].events[-1]) == ["Ada L.", None]


def test_the_tabs_of_one_player_are_one_visitor() -> None:
    salon = Salon()
    assert salon.appear(1, "Ada", who="a").you == 1
    assert salon.appear(2, "Ada", who="a").you == 1
    assert salon.appear(3, who="b").here == 2
    salon.presence.leave("r", 1)
    salon.wait(2.0)
    assert salon.ears[3].events[-1]["here"] == 2
    assert salon.presence.signed("r", 2, ACCEPTED).visitor == 1  # type: ignore[attr-defined]
    salon.presence.leave("r", 2)
    salon.wait(2.0)
    assert [visitor["visitor"] for visitor in salon.ears[3].events[-1]["visitors"]] == [2]


def test_an_audience_sees_visitors_and_is_none() -> None:
    salon = Salon()
    screen = salon.appear(1, audience=True)
    assert (screen.you, screen.here) == (msgspec.UNSET, 0)
    salon.appear(2, "Ada")
    salon.wait(0.0)
    assert names(salon.ears[1].events[-1]) == ["Ada"]
    assert salon.presence.signed("r", 1, ACCEPTED) == ACCEPTED
    assert salon.appear(2, audience=True).here == 0, "a visitor may become audience"


def test_however_often_something_changes_a_second_has_one_event() -> None:
    salon = Salon()
    salon.appear(1)
    for turn in range(50):
        salon.appear(2, f"name {turn}")
        salon.wait(0.1)
    assert len(salon.ears[1].events) <= 6
    salon.wait(2.0)
    assert names(salon.ears[1].events[-1]) == [None, "name 49"]
    assert salon.idle
    before = len(salon.ears[1].events)
    for _ in range(20):
        salon.presence.signed("r", 1, ACCEPTED)
        salon.wait(1.0)
    assert len(salon.ears[1].events) == before, "without changes there is none"


def test_others_know_a_newcomer_before_the_first_ball() -> None:
    salon = Salon()
    salon.appear(1)
    salon.wait(1.0)
    salon.appear(2, "Ben")
    salon.wait(0.0)
    salon.appear(3, "Cleo")
    ear = salon.ears[1]
    assert "Cleo" not in names(ear.events[-1]), "a second has one event"
    salon.presence.signed("r", 3, ACCEPTED)
    assert names(ear.events[-1]) == [None, "Ben", "Cleo"]
    before = len(ear.events)
    for _ in range(9):
        salon.presence.signed("r", 3, ACCEPTED)
    assert len(ear.events) == before, "a known visitor's balls wait for no list"
    salon.wait(5.0)
    assert salon.idle


def test_a_crowd_receives_few_names_less_often() -> None:
    salon = Salon()
    for number in range(2000):
        salon.appear(number, f"v{number}")
    salon.wait(20.0)
    ear = salon.ears[0]
    before = len(ear.events)
    for number in range(100):
        salon.presence.signed("r", number, ACCEPTED)
        salon.wait(1.0)
    assert len(ear.events) - before <= 100 * 200 / 2000 + 1, "200 messages a second, to all of them"
    last = ear.events[-1]
    assert last["here"] == 2000
    assert len(last["visitors"]) == MOST_NAMED
    assert set(names(last)) <= {f"v{number}" for number in range(100)}, "the players"
    assert max(map(len, ear.wire)) < 2000


def test_a_room_s_presence_ends_with_its_last_visitor() -> None:
    salon = Salon()
    salon.appear(1)
    salon.appear(2, room="s")
    salon.wait(1.0)
    before = len(salon.ears[2].events)
    salon.presence.leave("r", 1)
    salon.presence.leave("r", 1)
    salon.presence.leave("nowhere", 2)
    salon.wait(5.0)
    assert len(salon.ears[2].events) == before
    assert salon.appear(3).you == 1, "numbers begin again where nobody knows the old ones"


@pytest.mark.parametrize("stream", messages.STREAMS)
def test_a_ball_names_its_visitor_others_receive_only_balls(stream: str) -> None:
    salon = Salon()
    watched = Watched(salon.presence)
    ear = watched.join(1, stream)
    watched.drop(1, client=1)
    salon.appear(5)
    watched.drop(2, client=5)
    salon.presence.leave("r", 5)
    watched.drop(3, client=5)
    salon.wait(5.0)
    texts = [wire for wire in ear.wire if wire[0] == 0x81]
    ear.wire = texts
    told = [event for event in ear.events if event["type"] != "hello"]
    assert [event["type"] for event in told] == ["accepted"] * 3
    assert [event.get("visitor") for event in told] == [None, 1, None]


async def test_two_visitors_see_each_other_and_the_log_has_neither(
    server: Running,
) -> None:
    async with server.async_client() as http:
        made = (await http.post("/api/v1/rooms", json={"board": TINY})).json()
    url = server.socket(made["id"])
    async with playing(url) as ada, playing(url) as ben, playing(url) as old:
        await ada.send(type="appear", name="Ada Unkept", colour="#57c7ff")
        mine = await ada.until("presence", you=1)
        await ben.send(type="appear")
        await ada.until("presence", here=2)
        await ben.send(type="appear", name="<i>")
        assert (await ben.until("error"))["code"] == "invalid-value"
        await ada.send(type="drop", seed=1)
        assert (await old.until("accepted"))["visitor"] == 1
        for _ in range(9):
            await ben.send(type="appear", name="Ben")
        assert (await ben.until("error"))["code"] == "rate-limited"
    assert mine["visitors"] == [{"visitor": 1, "name": "Ada Unkept", "colour": "#57c7ff"}]
    assert not [event for event in old.events if event["type"] == "presence"]
    async with server.async_client() as http:
        owner = {"authorization": f"Bearer {made['token']}"}
        log = await http.get(f"/api/v1/rooms/{made['id']}/log", headers=owner)
    assert log.json()["drops"]
    assert "Unkept" not in log.text
    assert "57c7ff" not in log.text
    assert "visitor" not in log.text
