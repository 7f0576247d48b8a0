"""Metrics that only some servers expose."""

from typing import cast

from plinko.app.ops.metrics import Reading
from plinko.app.persistence.ledger.writer import Ledger
from plinko.app.persistence.statements.totals import Total
from plinko.app.relay.bus import readings as bus_readings
from plinko.app.web.readings import standing_readings
from plinko.app.web.returns import Returns
from plinko.app.web.shared import Standing
from plinko.app.webhooks.sender import Webhooks
from plinko.app.webhooks.targets import Target
from plinko.engine import Board
from tests.app.relay.memory_bus import MemoryBus
from tests.kit.null_ledger import NullLedger


def rare_readings() -> list[Reading]:
    """Readings that need a staked drop, a cluster, a webhook or Redis."""
    board = Board.preset("triangle-8")
    play = Total(board.digest, 100, False, plays=1, staked=100, squares=1e4, paid=0)
    among = Standing("plinko1", True, ["plinko1"], rooms=1, failed_over=0, migrated=0, forwarded=0)
    hooks = Webhooks([Target("http://example.org", "")], cast(Ledger, None), lambda: True)
    return [
        *Returns(NullLedger(), (play,)).readings(),
        *standing_readings(among),
        *hooks.readings(),
        *bus_readings(MemoryBus().join()),
    ]
