"""A server that cannot reach PostgreSQL for a while."""

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass

import httpx
import pytest

from tests.app.cluster.forwarder import Forwarder, forwarding, over_file, until_held
from tests.app.cluster.servers import Servers, member
from tests.app.cluster.test_servers import drop_at, new_room, same_as_alone, until_still
from tests.kit.postgres import PostgreSQL
from tests.kit.waiting import LIMIT, until

pytestmark = [pytest.mark.postgresql, pytest.mark.long("a server cut off until its lease runs out")]

TAKEN = (200, 202)


@dataclass
class Divided:
    """Servers, the first of which reaches PostgreSQL through a forwarder."""

    servers: Servers
    line: Forwarder


@pytest.fixture(scope="module")
def apart(postgresql: PostgreSQL) -> Iterator[Divided]:
    database = postgresql.new_database()
    name = database.partition("@/")[2].partition("?")[0]
    with contextlib.ExitStack() as stack:
        line = stack.enter_context(forwarding(over_file(f"{postgresql.folder}/.s.PGSQL.5432")))
        first = member("plinko1", ledger=f"postgresql://plinko@127.0.0.1:{line.port}/{name}")
        all_of_them = (first, member("plinko2"), member("plinko3"))
        yield Divided(stack.enter_context(Servers(database, all_of_them)), line)


def test_a_server_cut_off_loses_nothing_and_harms_nothing_later(
    apart: Divided,
) -> None:
    servers = apart.servers
    first, second, third = servers.all
    room = new_room(first)
    told = {drop_at(first, room, 70)["ball"]: 70}
    apart.line.held = 0
    apart.line.cut()
    try:
        answer = httpx.post(
            f"{first.url}/api/v1/rooms/{room}/drops", json={"seed": "71"}, timeout=LIMIT
        )
        assert answer.status_code not in TAKEN
        until_held(apart.line)
        until(lambda: any(servers.has(one, room) for one in (second, third)))
        told[drop_at(second, room, 72)["ball"]] = 72
    finally:
        apart.line.heal()
    until(
        lambda: all(servers.known_to(one) == {"plinko1", "plinko2", "plinko3"} for one in servers)
    )
    until(lambda: first.get("/readyz").status_code == 200)
    until(lambda: not servers.has(first, room))
    for number, one in enumerate(servers):
        told[drop_at(one, room, 80 + number)["ball"]] = 80 + number
    until_still(third, room)
    logs = [one.get(f"/api/v1/rooms/{room}/log").json()["drops"] for one in servers]
    assert logs[0] == logs[1] == logs[2]
    seeds = [int(each["seed"]) for each in logs[0]]
    assert {ball: seeds[ball] for ball in told} == told, "the ledger has what clients were sent"
    assert len(set(seeds)) == len(seeds), "nothing came in twice"
    assert set(seeds) <= {*told.values(), 71}
    for each, seed in zip(logs[0], seeds, strict=True):
        assert same_as_alone(each["result"], seed)
