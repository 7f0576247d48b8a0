"""Whatever happens to a table, clients receive and the ledger keeps the facts and their flights.

Hypothesis drops balls, refuses them, leaves commits in doubt, kills and starts servers, moves the
machine's clock, resets the room and repeats keys. The ledger is a list in memory.
"""

import asyncio
from collections.abc import Callable, Sequence
from typing import Any

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from plinko.app.errors import KeyReusedError, LedgerError
from plinko.app.live.broadcast.audience import Player
from plinko.app.live.live_table import LiveTable
from plinko.app.persistence.ledger.commit_queue import Done
from plinko.app.persistence.recovery.recovery import load_table
from plinko.app.persistence.statements import store
from plinko.app.protocol import messages
from plinko.app.rooms.independent import IndependentRoom
from plinko.app.rooms.keys import IdempotencyKey, KeyUse, UsedKey
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.records import (
    Close,
    DropRow,
    NewDrop,
    ResultRow,
    RoomRow,
    TableState,
    Write,
)
from plinko.app.settings import TICK_RATE
from plinko.engine import Board, drop
from tests.app.passes import rooms_by_hand, run_pass
from tests.kit.hand import HandClock
from tests.kit.null_ledger import NullLedger
from tests.kit.waiting import turns
from tests.long import tries

BOARD = Board.preset("triangle-8")
Place = tuple[int, int]  # of a run and a ball


async def board_of(run: int) -> Board:
    """Every run has this board."""
    return BOARD


class FakeLedger(NullLedger):
    """Makes facts when the test says so; `doubt` leaves a commit without an answer."""

    def __init__(self) -> None:
        super().__init__()
        self.facts: dict[Place, DropRow] = {}
        self.results: dict[Place, ResultRow] = {}
        self.keys: dict[tuple[str, str], UsedKey] = {}
        self.opened: dict[int, float] = {}
        self.closed: set[int] = set()
        self.waiting: list[tuple[NewDrop, asyncio.Future[None]]] = []

    async def drop(self, request: NewDrop, *before: Write) -> NewDrop:
        answer: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self.waiting.append((request, answer))
        self.take(before)
        await answer
        if request.error is not None:
            raise request.error
        return request

    def write(self, request: NewDrop) -> None:
        """The writer's turn."""
        run, key = request.room, request.key
        assert run not in self.closed, "a drop of a run that is over"
        if key is not None and (found := self.keys.get((key.scope, key.key))) is not None:
            try:
                place = (found.check(key).run, int(found.fact))
            except KeyReusedError as error:
                request.error = error
                return
            request.fact, request.earlier = self.facts[place], True
            request.result = self.results.get(place)
            return
        mine = [fact for place, fact in self.facts.items() if place[0] == run]
        last = mine[-1].tick if mine else 0
        fact = DropRow.of(run, len(mine), max(last, request.tick), request.command)
        self.facts[run, fact.ball] = request.fact = fact
        if key is not None:
            names = (key.scope, key.key, key.request)
            self.keys[key.scope, key.key] = UsedKey(*names, run, str(fact.ball))

    async def look_up(self, use: KeyUse) -> UsedKey | None:
        if use.key is not None and (found := self.keys.get((use.key.scope, use.key.key))):
            use.earlier = found.check(use.key)
        return use.earlier

    async def read(self, read: object, *args: Any, **values: Any) -> Any:
        if read is not store.drop:
            return await super().read(read, *args, **values)
        place = (values["run"], values["ball"])
        return self.facts[place], None, self.results.get(place)

    async def commit(self, *writes: Write, use: KeyUse | None = None) -> None:
        while self.waiting:  # a commit decides all jobs before it
            request, answer = self.waiting.pop(0)
            self.write(request)
            if not answer.done():
                answer.set_result(None)
        self.take(writes)

    def defer(self, writes: Sequence[Write], done: Done | None = None) -> None:
        self.take(writes)
        super().defer([], done)

    def take(self, writes: Sequence[Write]) -> None:
        for write in writes:
            if isinstance(write, ResultRow):
                self.results.setdefault((write.room, write.ball), write)
            elif isinstance(write, RoomRow):
                self.opened[write.number] = write.opened
            elif isinstance(write, Close):
                self.closed.add(write.room)

    def state(self, run: int) -> TableState:
        mine = [fact for place, fact in self.facts.items() if place[0] == run]
        sums: dict[int | None, int] = {}
        rest = 0
        for place, result in self.results.items():
            if place[0] == run:
                sums[result.bin] = sums.get(result.bin, 0) + 1
                rest = max(rest, result.tick)
        flying = [fact for fact in mine if (run, fact.ball) not in self.results]
        return TableState(len(mine), mine[-1].tick if mine else 0, rest, sums, flying)


class Tables(RuleBasedStateMachine):
    """One room over a ledger that outlives its servers."""

    def __init__(self) -> None:
        super().__init__()
        self.loop = asyncio.new_event_loop()
        self.clock = HandClock()
        self.ledger = FakeLedger()
        self.accepted: set[Place] = set()
        self.told: set[Place] = set()  # landings that this server has announced
        self.landed: dict[Place, messages.Landed] = {}
        self.seed = 0
        self.shown = 0
        self.asked: list[tuple[IdempotencyKey | None, int, asyncio.Task[Any]]] = []
        self.do(self.begin)

    def do(self, act: Callable[[], Any]) -> Any:
        async def run() -> Any:
            found = act()
            if asyncio.iscoroutine(found):
                found = await found
            await turns()
            return found

        return self.loop.run_until_complete(run())

    async def begin(self) -> None:
        self.rooms = rooms_by_hand(BOARD, self.clock, ledger=self.ledger)
        self.watch(await self.rooms.create(BOARD))

    def watch(self, live: Any) -> None:
        assert isinstance(live, LiveTable)
        self.live = live
        self.rooms.persistence.recovery.board_of = board_of  # type: ignore[method-assign]
        self.run = self.rooms.persistence.runs.of(live.room).number
        announce, broadcast = live.audience.announce, live.audience.broadcast

        def announced(seq: int, player: Player, event: Any) -> Any:
            if isinstance(event, messages.Accepted):
                place = (self.now_run, event.ball)
                assert place in self.ledger.facts, "announced before it is durable"
                assert place not in self.accepted, "announced twice"
                self.accepted.add(place)
            return announce(seq, player, event)

        def told(events: list[Any], *, with_snapshot: bool = False) -> None:
            for event in events:
                if isinstance(event, messages.Landed):
                    place = (self.now_run, event.ball)
                    assert place in self.ledger.facts, "a bin before its fact is durable"
                    assert place not in self.told, "landed twice"
                    self.told.add(place)
                    self.landed[place] = event
            broadcast(events, with_snapshot=with_snapshot)

        live.audience.announce = announced  # type: ignore[method-assign]
        live.audience.broadcast = told  # type: ignore[method-assign]

    @property
    def now_run(self) -> int:
        """The number of the run that the server shows."""
        return self.run

    @rule(key=st.none() | st.integers(0, 2), scope=st.sampled_from("ab"), stake=st.integers(0, 1))
    def drop(self, key: int | None, scope: str, stake: int) -> None:
        self.seed += 1
        named = None if key is None else IdempotencyKey(scope, str(key), str(stake))
        command = DropCommand(self.seed, stake=stake)
        asking = self.live.drop(command, Player(idempotency_key=named))
        task = self.do(lambda: asyncio.ensure_future(asking))
        self.asked.append((named, self.run, task))

    @precondition(lambda self: self.ledger.waiting)
    @rule()
    def commit(self) -> None:
        request, answer = self.ledger.waiting.pop(0)
        self.ledger.write(request)
        self.do(lambda: answer.set_result(None))

    @precondition(lambda self: self.ledger.waiting)
    @rule(there=st.booleans())
    def refuse_or_doubt(self, there: bool) -> None:
        """A commit fails; or it is there, but its answer comes only after a while."""
        request, answer = self.ledger.waiting.pop(0)
        if not there:
            self.do(lambda: answer.set_exception(LedgerError("lost")))
            assert request.fact is None, "a refused drop never had a number"
            return
        self.ledger.write(request)
        self.do(lambda: run_pass(self.rooms.runner, 30))
        self.do(lambda: answer.set_result(None))

    @rule(ticks=st.integers(1, 600))
    def tick(self, ticks: int) -> None:
        self.do(lambda: run_pass(self.rooms.runner, ticks))

    @rule()
    def reset(self) -> None:
        async def reset() -> None:
            before = self.run
            resetting = asyncio.create_task(self.rooms.reset(self.live))
            while not resetting.done():  # drops on their way enter at their tick first
                await turns()
                run_pass(self.rooms.runner)
            await resetting
            for (run, ball), _ in list(self.ledger.facts.items()):
                if run == before:
                    assert (run, ball) in self.ledger.results, "an end without a result"
            self.run = self.rooms.persistence.runs.of(self.live.room).number

        self.do(reset)
        self.shown = 0

    @rule(lost=st.integers(0, 1000), back=st.sampled_from([0, 0, 100, 5000]))
    def kill_and_start(self, lost: int, back: int) -> None:
        """The server is killed, and the machine's clock is set back before the next one starts."""
        self.ledger.waiting.clear()
        for task in asyncio.all_tasks(self.loop):
            task.cancel()
        self.do(lambda: None)
        self.asked.clear()
        self.clock.ticks = max(0, self.clock.ticks + lost - back)
        self.do(self.start)

    async def start(self) -> None:
        state, run = self.ledger.state(self.run), self.run
        self.rooms = rooms_by_hand(BOARD, self.clock, ledger=self.ledger)
        runs = self.rooms.persistence.runs
        runs.next_number = max([run, *self.ledger.opened]) + 1
        room = IndependentRoom("loaded", BOARD, tick_rate=TICK_RATE, max_balls=200)
        record = runs.made(run, owned=True, known=True)
        record.opened = self.ledger.opened[run]
        record.clock = runs.clock(record.opened, state.last)
        runs.begin(room.id, record)
        late = load_table(room, state, record.clock.tick)
        self.ledger.take(late)
        assert room.world.tick >= state.last, "no drop is in the future"
        self.told.clear()  # if the clock went back, it shows an unwritten landing again
        self.shown = 0
        self.watch(self.rooms._open.add(room))

    @invariant()
    def facts_are_consecutive_and_in_order(self) -> None:
        runs: dict[int, list[DropRow]] = {}
        for (run, _), fact in self.ledger.facts.items():
            runs.setdefault(run, []).append(fact)
        for facts in runs.values():
            assert [fact.ball for fact in facts] == [*range(len(facts))]
            assert [fact.tick for fact in facts] == sorted(fact.tick for fact in facts)

    @invariant()
    def each_landing_and_result_is_the_flight_of_its_fact(self) -> None:
        for place, event in self.landed.items():
            alone = drop(BOARD, self.ledger.facts[place].seed)
            assert (event.digest, event.bin) == (alone.digest, alone.bin)
        for place, result in self.ledger.results.items():
            assert result.digest == drop(BOARD, self.ledger.facts[place].seed).digest
            told = self.landed.get(place)
            assert told is None or (told.tick, told.payout or 0) == (result.tick, result.payout)

    @invariant()
    def the_room_shows_its_facts_at_its_clock(self) -> None:
        room = self.live.room
        state = self.ledger.state(self.run)
        assert room.drops <= state.drops
        assert room.drops == sum(room.histogram) + room.unsettled + len(room.balls)
        assert room.world.tick >= self.shown, "a tick was taken back"
        self.shown = room.world.tick
        for ball in room.balls:
            assert (self.run, ball.ball) in self.ledger.facts

    @invariant()
    def who_asked_hears_of_his_own_fact_only(self) -> None:
        for key, run, task in self.asked:
            if not task.done() or task.cancelled() or task.exception() is not None:
                continue
            outcome = task.result()
            if key is None:
                assert (run, outcome.accepted.ball) in self.ledger.facts
                continue
            used = self.ledger.keys[key.scope, key.key]
            fact = self.ledger.facts[used.run, int(used.fact)]
            assert used.request == key.request
            assert (outcome.accepted.ball, outcome.accepted.seed) == (fact.ball, str(fact.seed))

    def teardown(self) -> None:
        for task in asyncio.all_tasks(self.loop):
            task.cancel()
        self.do(lambda: None)
        self.loop.close()


TestTables = Tables.TestCase
TestTables.settings = settings(
    max_examples=tries(30, 300), stateful_step_count=tries(40, 60), deadline=None
)
