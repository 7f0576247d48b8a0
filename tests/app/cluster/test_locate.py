"""Who has a room, as a server finds it: few looks at the ledger, however many ask."""

import asyncio
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

from app.cluster.alive import Alive
from app.cluster.beats import Beats
from app.cluster.hand_over import HandOver
from app.cluster.line import Line
from app.cluster.membership import Member
from app.cluster.node import Node
from app.live.holding import Holding
from app.persistence.holds import Holds
from app.persistence.ledger.writer import Ledger
from app.rooms.records import HoldRow
from tests.waiting import turns

OTHER = Member("b.1", "b", "http://127.0.0.1:1")


class Desk:
    """A `Holding` and its `Holds`: a room that the other server has, and a ledger that waits."""

    holder, address = "a.1", ""

    def __init__(self) -> None:
        self.holds = self
        self.claim: Any = None
        self.looks = 0
        self.answers = asyncio.Event()
        self.left = asyncio.Event()
        self.leaving: set[str] = set()
        self.free = False  # nobody has the room

    def is_leaving(self, room_id: str) -> bool:
        return room_id in self.leaving

    async def until_left(self, room_id: str) -> None:
        if room_id in self.leaving:
            await self.left.wait()

    async def holder_of(self, room: str) -> HoldRow | None:
        self.looks += 1
        await self.answers.wait()
        if self.free:
            return None
        return HoldRow(room=room, number=1, holder=OTHER.holder, address=OTHER.address, taken=0.0)


def node_over(desk: Desk, *, has: Callable[[str], bool] = lambda _: False) -> Node:
    holding, line = cast(Holding, desk), cast(Line, SimpleNamespace())
    alive = Alive(cast(Beats, SimpleNamespace()), cast(Holds, desk), "a")
    hand_over = HandOver(alive, holding, line, watched=lambda _: 0)
    node = Node(alive, hand_over, holding, cast(Ledger, SimpleNamespace()), line, has=has)
    alive.view.members = {OTHER.holder: OTHER}
    return node


async def test_hundreds_who_look_for_a_room_at_once_cost_the_ledger_one_look() -> None:
    desk = Desk()
    node = node_over(desk)
    asking = [asyncio.create_task(node.locate("main")) for _ in range(300)]
    await turns()
    desk.answers.set()
    assert await asyncio.gather(*asking) == [OTHER] * 300
    assert desk.looks == 1
    assert await node.locate("main") == OTHER
    assert desk.looks == 2, "who comes later is told what is so then"


async def test_one_who_leaves_meanwhile_takes_the_answer_from_nobody() -> None:
    desk = Desk()
    node = node_over(desk)
    first, second = (asyncio.create_task(node.locate("main")) for _ in range(2))
    await turns()
    first.cancel()
    await turns()
    desk.answers.set()
    assert await second == OTHER


async def test_who_comes_to_a_room_that_is_leaving_waits_and_is_brought_where_it_went() -> None:
    desk = Desk()
    desk.answers.set()
    desk.leaving = {"main"}
    here = {"main"}
    node = node_over(desk, has=here.__contains__)
    assert not node.has("main")
    asked = asyncio.create_task(node.locate("main"))
    await turns()
    assert not asked.done()
    assert desk.looks == 0
    here.clear()
    desk.leaving = set()
    desk.left.set()
    assert await asked == OTHER


async def test_one_that_leaves_sends_on_who_asks_for_a_room_that_nobody_has() -> None:
    desk = Desk()
    desk.answers.set()
    desk.free = True
    node = node_over(desk)
    node.alive.leaving = True
    assert await node.locate("main") == OTHER
    assert desk.looks == 1
