"""When a write counts as refused, and when as undecided."""

import asyncio
from collections.abc import Iterator
from pathlib import Path

import pytest

from plinko.app.errors import LedgerError, UndecidedError
from tests.app.persistence.ledger.stepped import Table, failure

_LONG = 100  # awaits between a refusal and the end of the work, more than the server has


@pytest.fixture
def table(tmp_path: Path) -> Iterator[Table]:
    made = Table(f"sqlite:///{tmp_path / 'ledger.db'}", {})
    yield made
    made.end()


def fail_at(table: Table, wanted: str) -> None:
    """Let the database fail once, at this step of a commit."""

    def at(step: str) -> None:
        if step == wanted:
            table.database.at = lambda step: None
            raise failure()

    table.database.at = at


async def write_slowly(table: Table) -> None:
    """Write, and take many iterations of the event loop to pass a refusal on."""
    try:
        await table.ledger.commit()
    except LedgerError:
        for _ in range(_LONG):
            await asyncio.sleep(0)
        raise


def test_a_refusal_stays_one_however_long_its_owner_takes(table: Table) -> None:
    async def refused() -> LedgerError:
        with pytest.raises(LedgerError, match="cannot be written") as raised:
            await table.ledger.decided(write_slowly(table))
        return raised.value

    fail_at(table, "commit")
    assert not isinstance(table.until(refused()), UndecidedError)


def test_waiting_work_is_undecided_while_the_ledger_fails(
    table: Table,
) -> None:
    async def both() -> None:
        never = asyncio.get_running_loop().create_future()
        waiting = asyncio.ensure_future(table.ledger.decided(never))
        await asyncio.sleep(0)
        with pytest.raises(LedgerError, match="cannot be written"):
            await table.ledger.commit()
        with pytest.raises(UndecidedError):
            await waiting

    fail_at(table, "commit")
    table.until(both())
