"""The writer's turn: makes each drop a fact, with its number, tick, seed and receipt.

All of these follow from what the ledger has at this moment, inside the transaction. A request that
is refused never had a number, so nothing is ever taken back. A transaction that fails is simply
tried again, or its requests are refused.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

import sqlalchemy as sa
from sqlalchemy import Connection, func, select

from plinko.app.errors import (
    AppError,
    DamagedRoomError,
    KeyReusedError,
    LimitError,
    RepeatedError,
    SessionStateError,
)
from plinko.app.persistence.statements import fair_store, keys, store, tables
from plinko.app.protocol.messages import SignedReceipt
from plinko.app.rooms.keys import UsedKey
from plinko.app.rooms.records import (
    DropRow,
    FairEnd,
    InputRow,
    LogLeaf,
    NewDrop,
    NewInput,
    TableState,
)

_PAGE = 500  # drops read at once in the search for those without a result


def add_drops(connection: Connection, requests: Sequence[NewDrop]) -> None:
    """Make and write the facts of these requests, in order."""
    turn = _Turn(connection)
    for request in requests:
        request.fact = request.error = request.receipt = request.result = None
        request.earlier = False
        turn.take(request)
    turn.write()


@dataclass(slots=True)
class _Last:
    """The number and tick of a run's last drop; -1 and 0 before the first."""

    ball: int
    tick: int
    used: float = 0.0


class _Turn:
    """The requests of one transaction."""

    def __init__(self, connection: Connection) -> None:
        self._rows: list[DropRow] = []
        self._connection = connection
        self._last: dict[int, _Last] = {}  # by run
        self._drops: dict[str, int] = {}  # of open sessions
        self._repeats: list[tuple[NewDrop, UsedKey]] = []
        self._leaves: list[tuple[NewDrop, LogLeaf]] = []

    def take(self, request: NewDrop) -> None:
        """Make the fact of a request, or find the earlier one with its key, or set its error."""
        try:
            if not self._repeat(request):
                self._make(request)
        except KeyReusedError as error:
            request.error = error
        except (LimitError, SessionStateError) as error:
            request.error = error
            if request.key is not None:
                keys.release(self._connection, request.key)

    def _repeat(self, request: NewDrop) -> bool:
        """Use the request's key for the next ball; returns whether an earlier one has it."""
        if request.key is None:
            return False
        ball = self._last_of(request.room).ball + 1
        earlier = keys.use(self._connection, request.key, request.room, str(ball))
        if earlier is None:
            return False
        self._repeats.append((request, earlier))
        return True

    def _make(self, request: NewDrop) -> None:
        last, turn, command = self._last_of(request.room), request.session, request.command
        if turn is not None:
            turn.n = self._next_of(turn.session, turn.most)
            command = replace(command, seed=turn.seed_of(turn.n))
        tick = max(last.tick, request.tick)
        request.fact = fact = DropRow.of(request.room, last.ball + 1, tick, command)
        last.ball, last.tick, last.used = fact.ball, fact.tick, request.used
        self._rows.append(fact)
        if turn is not None:
            self._drops[turn.session] = turn.n + 1
            self._leaves.append((request, turn.leaf(turn.n, fact)))

    def _last_of(self, run: int) -> _Last:
        if run not in self._last:
            self._last[run] = _Last(*_last(self._connection, run))
        return self._last[run]

    def _next_of(self, session: str, most: int) -> int:
        """The number of an open session's next drop; raises SessionStateError, LimitError."""
        if session not in self._drops:
            row = tables.fair_sessions.c
            chosen = select(row.client_seed, row.end).where(row.id == session)
            found = self._connection.execute(chosen).first()
            if found is None or found.end is not None or found.client_seed is None:
                raise SessionStateError(f"session {session!r} is over", field="session")
            self._drops[session] = _drops_of(self._connection, session)
        if self._drops[session] >= most:
            raise LimitError(
                f"session {session!r} has had its {most} drops; end it and begin another",
                field="session",
            )
        return self._drops[session]

    def write(self) -> None:
        if self._rows:
            self._write_rows()
        for request, earlier in self._repeats:
            request.earlier = True
            try:
                found = store.drop(self._connection, earlier.run, int(earlier.fact))
            except DamagedRoomError as error:
                request.error = error
            else:
                request.fact, request.receipt, request.result = found

    def _write_rows(self) -> None:
        players = player_numbers(self._connection, {row.who for row in self._rows if row.who})
        rows = [asdict(row) for row in self._rows]
        for row in rows:
            row["player"] = players.get(row.pop("who"))
        self._connection.execute(sa.insert(tables.drops), rows)
        if self._leaves:
            fair_store.add_leaves(self._connection, [leaf for _, leaf in self._leaves])
        for request, leaf in self._leaves:
            request.receipt = SignedReceipt(leaf.receipt, leaf.index, leaf.root, leaf.signature)
        for run, last in self._last.items():
            if last.used:
                going_on = (tables.rooms.c.number == run) & tables.rooms.c.closed.is_(None)
                values = {"used": last.used, "tick": last.tick, "checkpoint_drops": last.ball + 1}
                marked = sa.update(tables.rooms).where(going_on).values(awake=True, **values)
                self._connection.execute(marked)


def player_numbers(connection: Connection, marks: set[str]) -> dict[str | None, int]:
    """The numbers of the players with these marks, new ones included."""
    if not marks:
        return {}
    row = tables.players
    # In one order, so that servers that share a ledger cannot deadlock.
    new = [{"who": who} for who in sorted(marks)]
    connection.execute(tables.adding(connection, row).on_conflict_do_nothing(), new)
    chosen = select(row.c.who, row.c.number).where(row.c.who.in_(marks))
    return {found.who: found.number for found in connection.execute(chosen)}


def _last(connection: Connection, run: int) -> tuple[int, int]:
    drop = tables.drops.c
    chosen = select(drop.ball, drop.tick).where(drop.room == run)
    found = connection.execute(chosen.order_by(drop.ball.desc()).limit(1)).first()
    return (-1, 0) if found is None else (found.ball, found.tick)


def _drops_of(connection: Connection, session: str) -> int:
    receipt = tables.receipts.c
    last = connection.scalar(select(func.max(receipt.number)).where(receipt.session == session))
    return 0 if last is None else int(last) + 1


def end_sessions(connection: Connection, rows: Sequence[FairEnd]) -> None:
    """End sessions with the number of drops that they have had; one that is over stays as it is."""
    for row in rows:
        session = tables.fair_sessions
        chosen = select(session.c.end, session.c.end_signature).where(session.c.id == row.session)
        found = connection.execute(chosen).first()
        if found is not None and found.end is not None:
            row.end, row.end_signature = found.end, found.end_signature or ""
            continue
        row.end, row.end_signature = row.sign(_drops_of(connection, row.session))
        fair_store.end(connection, row.session, row.end, row.end_signature)


def add_inputs(connection: Connection, requests: Sequence[NewInput]) -> None:
    """Write inputs of touching balls under the next numbers of their runs."""
    following: dict[int, int] = {}
    for request in requests:
        request.error = None
        if request.room not in following:
            row = tables.inputs.c
            chosen = select(func.max(row.number)).where(row.room == request.room)
            last = connection.scalar(chosen)
            following[request.room] = 0 if last is None else int(last) + 1
        number = following[request.room]
        if request.key is not None and (error := _refusal(connection, request, number)):
            request.error = error
            continue
        request.number = number
        following[request.room] += 1
        place = (request.room, number, request.tick)
        new = InputRow(*place, request.data, request.who)
        connection.execute(sa.insert(tables.inputs), [asdict(new)])


def _refusal(connection: Connection, request: NewInput, number: int) -> AppError | None:
    """Why an input with a key is refused; only the room's log has the outcome of a repeated one."""
    assert request.key is not None
    try:
        if keys.use(connection, request.key, request.room, str(number)) is None:
            return None
    except KeyReusedError as error:
        return error
    return RepeatedError(
        "a drop with this key was accepted before: look for it in the room's log", field="key"
    )


def table_state(connection: Connection, run: int) -> TableState:
    """The drops of a table's run: their sums, and those that have no result."""
    ball, tick = _last(connection, run)
    sums = sums_of(connection, run)
    missing = ball + 1 - sum(sums.values())
    flying = _missing(connection, run, ball + 1, missing)
    return TableState(ball + 1, tick, _rest(connection, run), sums, flying)


def sums_of(connection: Connection, run: int) -> dict[int | None, int]:
    """The number of a run's results by bin, None for balls without a bin."""
    tally = tables.tallies.c
    chosen = select(tally.bin, tally.results).where(tally.room == run)
    return {None if row.bin < 0 else row.bin: row.results for row in connection.execute(chosen)}


def _rest(connection: Connection, run: int) -> int:
    """The tick of the latest landing: that of one of the last drops, as a flight is not long."""
    result = tables.results.c
    last = select(result.tick).where(result.room == run).order_by(result.ball.desc()).limit(_PAGE)
    return int(connection.scalar(select(func.max(last.subquery().c.tick))) or 0)


def _missing(connection: Connection, run: int, end: int, count: int) -> list[DropRow]:
    """The drops without a result. They are among the last ones, so the search is short."""
    found: list[DropRow] = []
    start = connection.scalar(select(tables.rooms.c.pruned).where(tables.rooms.c.number == run))
    while len(found) < count and end > (start or 0):
        first = max(start or 0, end - _PAGE)
        page = store.drops(connection, run, first, end - first)
        found += [drop for drop, result in reversed(page) if result is None]
        end = first
    return found[::-1]


def state_at_end(connection: Connection, run: int, tick: int) -> TableState:
    """The drops of a run that was closed at `tick`, with those that had not landed by then."""
    ball, last = _last(connection, run)
    drop, result = tables.drops.c, tables.results.c
    of_run = result.room == run
    landed = of_run & (result.digest != "") & (result.tick <= tick)
    chosen = select(result.bin, func.count()).where(of_run, ~landed).group_by(result.bin)
    counts = Counter(sums_of(connection, run))
    counts.subtract({bin_: int(count) for bin_, count in connection.execute(chosen)})
    sums = dict(+counts)
    ended = select(result.ball).where(landed)
    flying = store.FACTS.where(drop.room == run, drop.ball.not_in(ended))
    rows = connection.execute(flying.order_by(drop.ball))
    flown = [store.drop_of(*row) for row in rows]
    return TableState(ball + 1, last, tick, sums, flown)
