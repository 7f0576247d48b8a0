"""The writer's turn: makes each drop a fact, with its number, tick, seed and receipt.

All of these follow from what the ledger has at this moment, inside the transaction. A request that
is refused never had a number, so nothing is ever taken back. A transaction that fails is simply
tried again, or its requests are refused.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import sqlalchemy as sa
from sqlalchemy import Connection, func, select

from app.errors import KeyReusedError, LimitError, RepeatedError, SessionStateError
from app.persistence.statements import fair_store, store, tables
from app.rooms.records import (
    DropRow,
    FairEnd,
    IdempotencyKey,
    InputRow,
    LogLeaf,
    NewDrop,
    NewInput,
    TableState,
)

_PAGE = 500  # drops read at once in the search for those without a result


def add_drops(connection: Connection, requests: Sequence[NewDrop]) -> list[DropRow]:
    """Make and write the facts of these requests, in order; returns the new ones."""
    turn = _Turn(connection)
    for request in requests:
        request.fact = request.error = request.receipt = request.result = None
        request.earlier = False
        turn.take(request)
    turn.write()
    return turn.rows


@dataclass(slots=True)
class _Last:
    """The number and tick of a run's last drop; -1 and 0 before the first."""

    ball: int
    tick: int
    used: float = 0.0


class _Turn:
    """The requests of one transaction."""

    def __init__(self, connection: Connection) -> None:
        self.rows: list[DropRow] = []
        self._connection = connection
        self._last: dict[int, _Last] = {}  # by run
        self._drops: dict[str, int] = {}  # of open sessions
        self._keyed: dict[tuple[int, str, str], NewDrop] = {}
        self._leaves: list[tuple[NewDrop, LogLeaf]] = []

    def take(self, request: NewDrop) -> None:
        """Make the fact of a request, or find the earlier one with its key, or set its error."""
        try:
            if not self._repeats(request):
                self._make(request)
        except (KeyReusedError, LimitError, SessionStateError) as error:
            request.error = error

    def _repeats(self, request: NewDrop) -> bool:
        key = request.key
        if key is None:
            return False
        before = self._keyed.get((request.room, key.scope, key.key))
        if before is not None:
            _check_same(key, before.key.request if before.key else None)
            request.fact, request.earlier = before.fact, True
            # The receipt is complete only when the leaves are written.
            self._leaves += [(request, leaf) for each, leaf in self._leaves if each is before]
            return True
        found = store.keyed_drop(self._connection, request.room, key)
        if found is None:
            return False
        request.fact, request.receipt, request.result = found
        _check_same(key, request.fact.request)
        request.earlier = True
        return True

    def _make(self, request: NewDrop) -> None:
        last, turn, seed = self._last_of(request.room), request.session, request.seed
        if turn is not None:
            turn.n = self._next_of(turn.session, turn.most)
            seed = turn.seed_of(turn.n)
        key = request.key
        request.fact = DropRow(
            room=request.room,
            ball=last.ball + 1,
            tick=max(last.tick, request.tick),
            seed=seed,
            x=request.x,
            stake=request.stake,
            who=request.who,
            aim=request.aim,
            practice=request.practice,
            key=None if key is None else key.key,
            scope=None if key is None else key.scope,
            request=None if key is None else key.request,
            **request.tag.fields,
        )
        last.ball, last.tick, last.used = request.fact.ball, request.fact.tick, request.used
        self.rows.append(request.fact)
        if key is not None:
            self._keyed[request.room, key.scope, key.key] = request
        if turn is not None:
            self._drops[turn.session] = turn.n + 1
            self._leaves.append((request, turn.leaf(turn.n, request.fact)))

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
        if not self.rows:
            return
        self._connection.execute(
            sa.insert(tables.drops), [asdict(row) | {"seed": str(row.seed)} for row in self.rows]
        )
        new = [leaf for request, leaf in self._leaves if not request.earlier]
        if new:
            fair_store.add_leaves(self._connection, new)
        for request, leaf in self._leaves:
            request.receipt = fair_store.receipt_of(leaf)
        for run, last in self._last.items():
            if last.used:
                going_on = (tables.rooms.c.number == run) & tables.rooms.c.closed.is_(None)
                values = {"used": last.used, "tick": last.tick, "checkpoint_drops": last.ball + 1}
                marked = sa.update(tables.rooms).where(going_on).values(awake=True, **values)
                self._connection.execute(marked)


def _check_same(key: IdempotencyKey, before: str | None) -> None:
    if before != key.request:
        raise KeyReusedError(
            "this key was used before for another drop; use a new key for each request",
            field="key",
        )


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
        values = {"end": row.end, "end_signature": row.end_signature}
        connection.execute(sa.update(session).where(session.c.id == row.session).values(values))


def add_inputs(connection: Connection, requests: Sequence[NewInput]) -> None:
    """Write inputs of touching balls under the next numbers of their runs."""
    following: dict[int, int] = {}
    for request in requests:
        request.error, key = None, request.key
        if key is not None and (before := store.keyed_input(connection, request.room, key)):
            request.error = _told(key, before)
            continue
        if request.room not in following:
            number = tables.inputs.c.number
            chosen = select(func.max(number)).where(tables.inputs.c.room == request.room)
            last = connection.scalar(chosen)
            following[request.room] = 0 if last is None else int(last) + 1
        request.number = following[request.room]
        following[request.room] += 1
        names = {} if key is None else asdict(key)
        place = (request.room, request.number, request.tick, request.data, request.who)
        connection.execute(sa.insert(tables.inputs), [asdict(InputRow(*place, **names))])


def _told(key: IdempotencyKey, before: str | None) -> Exception:
    """The error of a repeated input, whose outcome only the room's log has."""
    try:
        _check_same(key, before)
    except KeyReusedError as error:
        return error
    return RepeatedError(
        "a drop with this key was accepted before: look for it in the room's log", field="key"
    )


def table_state(connection: Connection, run: int) -> TableState:
    """The drops of a table's run: their sums, and those that have no result."""
    ball, tick = _last(connection, run)
    tally = tables.tallies.c
    chosen = select(tally.bin, tally.results).where(tally.room == run)
    sums = {None if row.bin < 0 else row.bin: row.results for row in connection.execute(chosen)}
    missing = ball + 1 - sum(sums.values())
    flying = _missing(connection, run, ball + 1, missing)
    return TableState(ball + 1, tick, _rest(connection, run), sums, flying)


def _rest(connection: Connection, run: int) -> int:
    """The tick of the latest landing: that of one of the last drops, as a flight is not long."""
    result = tables.results.c
    last = select(result.tick).where(result.room == run).order_by(result.ball.desc()).limit(_PAGE)
    return int(connection.scalar(select(func.max(last.subquery().c.tick))) or 0)


def _missing(connection: Connection, run: int, end: int, count: int) -> list[DropRow]:
    """The drops without a result. They are among the last ones, so the search is short."""
    found: list[DropRow] = []
    while len(found) < count and end > 0:
        first = max(0, end - _PAGE)
        page = store.drops(connection, run, first, end - first)
        found += [drop for drop, result in reversed(page) if result is None]
        end = first
    return found[::-1]


def state_at_end(connection: Connection, run: int, tick: int) -> TableState:
    """The drops of a run that was closed at `tick`, with those that had not landed by then."""
    ball, last = _last(connection, run)
    drop, result = tables.drops.c, tables.results.c
    landed = (result.room == run) & (result.digest != "") & (result.tick <= tick)
    chosen = select(result.bin, func.count()).where(landed).group_by(result.bin)
    sums = {bin_: int(count) for bin_, count in connection.execute(chosen)}
    ended = select(result.ball).where(landed)
    flying = select(tables.drops).where(drop.room == run, drop.ball.not_in(ended))
    rows = connection.execute(flying.order_by(drop.ball))
    flown = [store.drop_of(*row) for row in rows]
    return TableState(ball + 1, last, tick, sums, flown)
