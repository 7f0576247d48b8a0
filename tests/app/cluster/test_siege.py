"""Servers that share a ledger are killed, stopped, frozen and cut off while many play.

At the end the ledger has every acknowledged drop, with the result that the engine alone computes;
no ball lands twice, and no client receives an earlier tick after a later one.
"""

import os
import random
from collections import Counter

import pytest

from tests.app.cluster.servers import Servers
from tests.app.cluster.siege import ACKNOWLEDGED, KILLS, ROOMS, Siege
from tests.app.cluster.watchers import SENT_ON, spread
from tests.kit.postgres import PostgreSQL


def siege_of(servers: Servers, postgresql: PostgreSQL) -> Siege:
    """A siege; the environment may give its random seed."""
    chance = random.Random(int(os.environ.get("PLINKO_TEST_SEED", "1")))
    siege = Siege(servers=servers, postgresql=postgresql, chance=chance)
    siege.begin()
    return siege


pytestmark = [pytest.mark.postgresql, pytest.mark.long("a siege of three servers")]


@pytest.mark.timeout(4 * 3600)
async def test_no_acknowledged_ball_is_lost_and_none_lands_twice(
    servers: Servers, postgresql: PostgreSQL
) -> None:
    siege = siege_of(servers, postgresql)
    async with siege.going_on():
        await siege.stand()
    drops = siege.check()
    assert siege.acknowledged >= ACKNOWLEDGED * KILLS * ROOMS
    assert drops >= siege.acknowledged
    happened = dict(Counter(name for name, _ in siege.happened))
    print(  # noqa: T201
        f"{happened}: {siege.acknowledged} acknowledged drops of {drops}, none lost\n"
        f"rooms of killed servers, from the kill until they greet: {spread(siege.failed_over)}"
    )
    for fault, gaps in siege.gaps.items():
        print(f"without a frame after {fault!r}: {spread(gaps)}")  # noqa: T201


@pytest.mark.timeout(3600)
async def test_servers_are_upgraded_in_turn_and_all_viewers_follow(
    servers: Servers, postgresql: PostgreSQL
) -> None:
    siege = siege_of(servers, postgresql)
    async with siege.going_on():
        await siege.roll()
    assert siege.check() >= siege.acknowledged
    assert siege.breaks, "somebody was sent on"
    codes = sum((watcher.codes for watcher in siege.watchers), Counter())
    assert set(codes) == {SENT_ON}, "and no client received an error"
    vain = sum(each.vain > 0 for each in siege.breaks)
    print(  # noqa: T201
        f"gaps of the clients that moved: {spread(siege.gaps['end'])}; "
        f"{vain} of them came in vain before; "
        f"at most {max(each.ticks for each in siege.breaks)} ticks passed meanwhile"
    )
