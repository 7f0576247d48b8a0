"""A fault at every step of a commit: an error, a stall, a cut connection, the process's end.

SQLite tests itself in this way: the same play runs again and again, with the fault one step later
each time, until a play ends before the fault happens.
"""

import asyncio
import contextlib
import random
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from plinko.app.errors import LedgerError
from plinko.app.rooms.kinds import INTERACTING
from plinko.app.rooms.log import verify_log
from plinko.engine import Board
from tests.app.conftest import TINY
from tests.app.persistence.ledger.stepped import PATIENCE, Table, failure
from tests.kit.told import Told, hold
from tests.long import tries

pytestmark = pytest.mark.timeout(7200)  # LONG=1: four hundred plays, or every step of one

BOARD = Board.from_json(TINY)
PUBLIC = "triangle-8"


class EndError(BaseException):
    """The process ends here."""


@dataclass
class Play:
    """Players in three rooms: a public room that is new, a private room, a room of touching balls.

    `fault` happens at the step number `step` of the ledger after the fault is armed.
    """

    url: str
    fault: Callable[["Play"], None]
    step: int
    only: Sequence[str] = ()  # if given, only at steps of these names
    table: Table = field(init=False)
    told: dict[str, Told] = field(default_factory=dict)
    steps: int = 0
    armed: bool = False
    met: str = ""
    seed: int = 0

    def begin(self) -> None:
        self.told[PUBLIC] = Told(PUBLIC)
        self.table = Table(self.url, self.told)
        self.table.until(self.table.rooms.resume())
        self.table.until(self.table.rooms.seek(PUBLIC))
        for mode in ("independent", INTERACTING):
            room = self.table.until(self.table.rooms.create(BOARD, mode))
            self.told[room.id] = Told(room.id)
        self.own, self.touching = list(self.told)[1:]
        self.table.database.at = self.at

    def at(self, step: str) -> None:
        self.steps += self.armed
        if self.armed and self.steps >= self.step and (step in self.only or not self.only):
            self.armed = False
            self.met = step
            self.fault(self)

    def ask(self, *rooms: str) -> list["asyncio.Task[Any] | None"]:
        return [self._ask(room) for room in rooms]

    def _ask(self, room: str) -> "asyncio.Task[Any] | None":
        self.seed += 1
        return self.table.asks(room, self.seed, 0 if room == self.touching else 10 * self.seed)

    def drop_everywhere(self) -> None:
        self.ask(self.own, PUBLIC, self.touching, self.own, self.touching)

    def amid_faults(self) -> None:
        """Play everything that makes the ledger write; the fault happens somewhere on the way."""
        table = self.table
        self.drop_everywhere()
        table.work()
        table.tick(8)
        self.armed = True
        self.drop_everywhere()
        table.turn()
        self.drop_everywhere()  # before the loop runs the ledger's callbacks
        table.work()
        table.tick(40)  # balls land, and rooms write how far they may tick
        self.drop_everywhere()
        with contextlib.suppress(LedgerError):
            table.until(self._own_room())
        table.tick(30)
        table.work()

    async def _own_room(self) -> None:
        """Create, reset and close a room; raises LedgerError."""
        room = await self.table.rooms.create(BOARD)
        await self.table.rooms.reset(room)
        await self.table.rooms.delete(room)

    def calm(self) -> None:
        """After the fault: check that every room accepts drops again."""
        table = self.table
        self.armed = False
        table.work()
        assert table.ledger.up, table.ledger.problem
        for room in (self.own, PUBLIC, self.touching):
            (asked,) = self.ask(room)
            table.work()
            assert asked is not None
            table.tick(60)
            table.work()
            assert asked.done()
            assert asked.exception() is None, f"{room} after a fault at {self.met}"
        table.until_still()

    def check(self, *, killed: bool = False) -> None:
        """Check that events, ledger and physics agree in every room."""
        logs = {room: self.table.log(room) for room in self.told}
        assert all(verify_log(log).ok for log in logs.values())
        touching = self.told[self.touching]
        kept = [(each["input"]["seed"], each["tick"]) for each in logs[self.touching]["inputs"]]
        said = [(each["seed"], each["tick"]) for each in touching.accepted.values()]
        assert set(said) <= set(kept)
        assert killed or len(said) == len(kept), "each row was announced"
        self.table.end()
        hold(self.url, self.told[PUBLIC], Board.preset(PUBLIC), killed=killed)
        hold(self.url, self.told[self.own], BOARD, killed=killed)

    def again(self) -> None:
        """Start another server with the same ledger."""
        self.table.end()
        self.table = Table(self.url, self.told)
        self.table.until(self.table.rooms.resume())
        for room in self.told:
            self.table.until(self.table.rooms.seek(room))


def error(play: Play) -> None:
    raise failure()


def stall(seconds: float) -> Callable[[Play], None]:
    """The database does not answer for this long; players go on meanwhile."""

    def fault(play: Play) -> None:
        table = play.table
        table.loop.pass_time(seconds / 2)
        play.drop_everywhere()
        table.tick(5)
        table.loop.pass_time(seconds / 2)
        if not table.ledger.up:
            assert play.ask(play.own, PUBLIC, play.touching) == [None] * 3
            with pytest.raises(LedgerError, match="not answered for 2 seconds"):
                table.within(table.ledger.submit)
        table.tick(5)

    return fault


def stall_and_cut(play: Play) -> None:
    stall(1.5 * PATIENCE)(play)
    raise failure()


def freeze(play: Play) -> None:
    play.table.loop.freeze(10.0)
    play.table.tick(1)


def end(play: Play) -> None:
    raise EndError


def end_after_a_stall(play: Play) -> None:
    stall(1.5 * PATIENCE)(play)
    raise EndError


FAULTS = {
    "error": error,
    "short stall": stall(0.75 * PATIENCE),
    "stall": stall(1.5 * PATIENCE),
    "stall and cut": stall_and_cut,
    "frozen process": freeze,
}


@pytest.mark.long
@pytest.mark.parametrize("name", FAULTS)
def test_no_fault_at_any_step_loses_anything(name: str, empty: Path, tmp_path: Path) -> None:
    at_each_step(empty, tmp_path, FAULTS[name], killed=False)


@pytest.mark.long
@pytest.mark.parametrize("fault", [end, end_after_a_stall])
def test_after_any_crash_the_next_process_has_all_accepted(
    fault: Callable[[Play], None], empty: Path, tmp_path: Path
) -> None:
    at_each_step(empty, tmp_path, fault, killed=True)


SECONDS = tries((1.7, 10.0), (0.5, 1.0, 1.7, 2.0, 2.2, 2.5, 3.0, 4.0, 6.0, 8.0, 10.0))
"""Durations of stalls in s, shorter and longer than the ledger's patience."""

STALLED = {
    "lock": ("BEGIN IMMEDIATE", False),
    "lock that is never had": ("BEGIN IMMEDIATE", True),
    "slow commit": ("commit", False),
    "cut before the commit": ("commit", True),
    "commit that comes through": ("committed", False),
    "cut after the commit": ("committed", True),
}


@pytest.mark.long
@pytest.mark.parametrize("name", STALLED)
def test_no_stall_of_any_length_loses_anything(name: str, empty: Path, tmp_path: Path) -> None:
    step, cut = STALLED[name]
    for seconds in SECONDS:

        def fault(play: Play, seconds: float = seconds) -> None:
            stall(seconds)(play)
            if cut:
                raise failure()

        file = tmp_path / f"{seconds}.db"
        shutil.copy(empty, file)
        play = Play(f"sqlite:///{file}", fault, 1, only=(step,))
        play.begin()
        play.amid_faults()
        assert play.met == step
        refused = bool(play.told[PUBLIC].refused)
        lost = cut and step != "committed"  # a finished commit is found after the cut
        # The thread is checked four times within the patience: a stall may be a quarter longer.
        assert refused or not (lost or seconds > 1.25 * PATIENCE)
        assert cut or not (refused and seconds < PATIENCE)
        play.calm()
        play.check()


def at_each_step(empty: Path, folder: Path, fault: Callable[[Play], None], *, killed: bool) -> None:
    """Run the play with the fault at each step in turn, or only before and after a commit."""
    step, met = 0, ""
    while step == 0 or met:
        step += 1
        file = folder / f"{step}.db"
        shutil.copy(empty, file)
        play = Play(f"sqlite:///{file}", fault, step, only=tries(("commit", "committed"), ()))
        play.begin()
        with contextlib.suppress(EndError):
            play.amid_faults()
        met, step = play.met, play.steps
        if killed and met:
            play.again()
        play.calm()
        play.check(killed=killed)
        if met == tries("committed", ""):
            break
    assert step > tries(5, 50)


@given(chance=st.randoms(use_true_random=False))
@settings(max_examples=tries(3, 400), suppress_health_check=[HealthCheck.function_scoped_fixture])
@pytest.mark.long
def test_no_order_of_the_two_threads_loses_anything(
    chance: random.Random, empty: Path, tmp_path: Path
) -> None:
    file = tmp_path / "plinko.db"
    for left in tmp_path.iterdir():
        left.unlink()
    shutil.copy(empty, file)
    _at_random(chance, f"sqlite:///{file}")


def _at_random(chance: random.Random, url: str) -> None:
    """Players, clock and loop act at random, also at every step of the database."""

    def anything(play: Play) -> None:
        if not play.met:
            return
        play.met = ""  # a step must not start another random action
        match chance.randrange(40):
            case 0:
                raise failure()
            case 1 | 2:
                play.table.loop.pass_time(chance.uniform(0.1, 1.5 * PATIENCE))
            case 3 | 4:
                play.ask(chance.choice(list(play.told)))
            case 5:
                play.table.loop.deliver()
            case 6:
                play.table.tick(chance.randrange(30))
            case 7:
                play.table.loop.freeze(3.0)
        play.met = "between two steps"

    play = Play(url, anything, 0)
    play.begin()
    try:  # Hypothesis aborts an example that makes too many choices
        table = play.table
        table.database.at = lambda step: anything(play)
        play.met = "between two steps"
        for _ in range(40):
            match chance.randrange(4):
                case 0:
                    play.ask(*chance.choices(list(play.told), k=3))
                case 1 if not table.idle:
                    table.turn()
                case 2:
                    table.loop.deliver()
                case 3:
                    table.tick(chance.randrange(20))
        play.met = ""
        play.calm()
        play.check()
    finally:
        play.table.end()
