"""Servers that share a ledger go by its database's clock."""

from dataclasses import dataclass
from typing import Any

from plinko.app.persistence.clock import SteadyClock
from plinko.app.persistence.room_runs import RoomRuns
from tests.kit.null_ledger import NullLedger


@dataclass
class Database:
    """A database, and a ledger whose answers reach the event loop three seconds late."""

    seconds: float = 0.0  # of the monotonic clock

    def scalar(self, _: object) -> float:
        return 1e9 + self.seconds

    async def read(self, read: Any) -> Any:
        answer = read(self)
        self.seconds += 3.0
        return answer


async def test_a_busy_server_s_clock_is_not_late() -> None:
    database, ledger = Database(), NullLedger()
    ledger.read = database.read  # type: ignore[method-assign]
    clock = SteadyClock(lambda: database.seconds, lambda: 0.0)
    await RoomRuns(ledger, clock).follow_database()
    assert clock() == 1e9 + 3.0
