"""A look is made once for all who ask while it lasts, and ends with none of them."""

import asyncio

import pytest

from app.errors import LedgerError
from app.live.looks import Looks
from tests.waiting import turns


class Ledger:
    """Answers when it is told to."""

    def __init__(self) -> None:
        self.looks = 0
        self.answers = asyncio.Event()
        self.broken = False

    async def look(self) -> int:
        self.looks += 1
        number = self.looks
        await self.answers.wait()
        if self.broken:
            raise LedgerError("it is gone")
        return number


async def test_all_who_ask_meanwhile_have_one_look_and_who_comes_later_the_next() -> None:
    ledger, looks = Ledger(), Looks[int]()
    asking = [asyncio.create_task(looks.look("main", ledger.look)) for _ in range(100)]
    other = asyncio.create_task(looks.look("classic", ledger.look))
    await turns()
    ledger.answers.set()
    assert await asyncio.gather(*asking) == [1] * 100
    assert await other == 2
    assert await looks.look("main", ledger.look) == 3


async def test_who_leaves_takes_the_answer_from_nobody_and_all_hear_of_a_failure() -> None:
    ledger, looks = Ledger(), Looks[int]()
    first, second, third = (asyncio.create_task(looks.look("main", ledger.look)) for _ in range(3))
    await turns()
    first.cancel()
    await turns()
    ledger.broken = True
    ledger.answers.set()
    for asked in (second, third):
        with pytest.raises(LedgerError, match="it is gone"):
            await asked
    assert ledger.looks == 1
