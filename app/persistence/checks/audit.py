"""Audits every room run: recomputes its numbers, boards, results, payouts and checkpoints.

Reads a ledger that no server is using. Each run is checked by itself, so damage in one does not
hide damage in the next.
"""

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, replace
from typing import Final

import sqlalchemy as sa
from sqlalchemy import Connection

from plinko.app.persistence.ledger.database import Database, reason
from plinko.app.persistence.recovery.rebuild import Replay, basis_of
from plinko.app.persistence.statements import store, tables
from plinko.app.rooms.kinds import NO_LIMIT, format_of
from plinko.app.rooms.outcome import computed
from plinko.app.rooms.records import DropRow, ResultRow, RoomRow, TakenRow
from plinko.app.rooms.room import Basis
from plinko.app.rooms.stakes import payout_of
from plinko.engine import PHYSICS_VERSION

_PAGE: Final = 1000  # rows read at once


@dataclass(frozen=True, slots=True)
class Finding:
    session: int
    room: str
    what: str


@dataclass(slots=True)
class Audit:
    """Counts of what was checked, and the findings.

    other_physics: number of runs of another physics version. For these, this release can recompute
    the payouts but not the results.
    """

    sessions: int = 0
    drops: int = 0
    inputs: int = 0
    results: int = 0
    other_physics: int = 0
    findings: list[Finding] = field(default_factory=list)

    def look(self, database: Database, number: int, *, replay: bool) -> None:
        """Check run `number`; with `replay`, replay an open room from tick 0 too.

        Raises SQLAlchemy's errors if the database cannot be read for a reason other than damage.
        """
        self.sessions += 1
        room = ""
        try:
            with database.transaction() as connection:
                row = store.run(connection, number)
                room = row.id
                self.other_physics += row.physics_version != PHYSICS_VERSION
                for what in _RunCheck(self, connection, row, replay).check():
                    self.findings.append(Finding(number, room, what))
        except sa.exc.DatabaseError as error:
            if type(error) is not sa.exc.DatabaseError:
                raise
            what = f"its pages in the database are damaged: {reason(error)}"
            self.findings.append(Finding(number, room, what))
        except Exception as error:  # noqa: BLE001 - the other runs are still checked
            self.findings.append(Finding(number, room, str(error)))


class _RunCheck:
    def __init__(self, audit: Audit, connection: Connection, row: RoomRow, replay: bool) -> None:
        self._audit = audit
        self._connection = connection
        self._row = row
        self._from_start = replay
        self._inputs = format_of(row.mode)
        self._current = row.physics_version == PHYSICS_VERSION

    def check(self) -> Iterator[str]:
        """All faults; raises an error for a fault after which nothing more can be checked."""
        kept = store.basis(self._connection, self._row.board, self._row.draw)
        basis = basis_of(self._row, kept)
        count, tick = self._row.pruned, 0
        for row, result in self._taken(count):
            if row.tick < tick:
                yield f"input {row.number} has tick {row.tick}, but the one before has tick {tick}"
            count, tick = count + 1, max(tick, row.tick)
            if isinstance(row, DropRow):
                yield from self._check_drop(basis, row, result)
            else:
                self._audit.inputs += 1
                self._inputs.check(
                    f"input {row.number}", row.number, self._inputs.entry(row, None, row.tick)
                )
        if count < self._row.checkpoint_drops:
            yield f"it has {count} inputs, but its row says {self._row.checkpoint_drops}"
        yield from self._check_orphans()
        if self._row.closed is None and self._current:
            yield from self._check_way_back(basis)

    def _taken(self, first: int) -> Iterator[tuple[TakenRow, ResultRow | None]]:
        """Inputs from number `first` on, each with its result; raises DamagedRoomError at a gap."""
        while True:
            name = self._inputs.name
            page = store.stored_inputs(self._connection, name, self._row.number, first, _PAGE)
            yield from page
            first += len(page)
            if len(page) < _PAGE:
                return

    def _check_drop(self, basis: Basis, row: DropRow, result: ResultRow | None) -> Iterator[str]:
        self._audit.drops += 1
        if result is None:
            if self._row.closed is None and not self._row.awake:
                yield f"drop {row.ball} has no result, but nothing moves in the room"
            return
        self._audit.results += 1
        wanted = _expected(basis, row, result, self._row.tick_rate, compute=self._current)
        for name, value in wanted.items():
            said = getattr(result, name)
            if said != value:
                yield f"drop {row.ball}: the ledger has {name} {said!r}, correct is {value!r}"

    def _check_orphans(self) -> Iterator[str]:
        """Results without a drop: the only trace of drops that are missing at the end."""
        result, dropped = tables.results.c, tables.drops.c
        chosen = (
            sa.select(result.ball)
            .outerjoin(tables.drops)
            .where(result.room == self._row.number, dropped.ball.is_(None))
            .order_by(result.ball)
        )
        for (ball,) in self._connection.execute(chosen):
            yield f"drop {ball} has a result but is missing"

    def _check_way_back(self, basis: Basis) -> Iterator[str]:
        """Whether the room can be loaded: a table's sums, or the replay of touching balls."""
        if self._inputs.has_results:
            yield from self._check_sums()
            return
        resumed = self._replay(self._row, basis)
        if not self._from_start or self._row.checkpoint is None:
            return
        again = self._replay(replace(self._row, checkpoint=None, checkpoint_drops=0), basis)
        # The replay from the first tick ends at the last input; the checkpoint may be later.
        again.room.advance(resumed.room.world.tick)
        if again.room.world.digest != resumed.room.world.digest:
            yield "its checkpoint differs from the replay of its inputs"

    def _check_sums(self) -> Iterator[str]:
        result, tally = tables.results.c, tables.tallies.c
        counted = sa.func.coalesce(result.bin, -1)
        chosen = sa.select(counted, sa.func.count()).where(result.room == self._row.number)
        rows = self._connection.execute(chosen.group_by(counted))
        found: dict[int, int] = {row[0]: row[1] for row in rows}
        kept = sa.select(tally.bin, tally.results).where(tally.room == self._row.number)
        said = {row.bin: row.results for row in self._connection.execute(kept)}
        for bin_ in sorted(found.keys() | said.keys()):
            more = found.get(bin_, 0) - said.get(bin_, 0)
            if more > 0 or (more < 0 and not self._row.pruned):
                where = "no bin" if bin_ < 0 else f"bin {bin_}"
                yield f"{found.get(bin_, 0)} results have {where}; {said.get(bin_, 0)} are counted"

    def _replay(self, row: RoomRow, basis: Basis) -> Replay:
        replay = Replay(row, basis, limits=NO_LIMIT)
        replay.take(store.inputs(self._connection, row.number, replay.next_input))
        replay.run(to_end=True)
        return replay


def _expected(
    basis: Basis, row: DropRow, result: ResultRow, tick_rate: int, *, compute: bool
) -> dict[str, object]:
    """The correct values of a drop's result: all of them if `compute`, else only its payout."""
    if not result.digest:  # it could not be computed, or was given up: its stake was returned
        return {"bin": None, "score": 1.0, "payout": row.stake}
    if not compute:
        return {"payout": payout_of(row.stake, result.score)}
    return asdict(computed(basis, row, tick_rate))
