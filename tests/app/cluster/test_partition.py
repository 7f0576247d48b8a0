"""A server that does not reach Redis, PostgreSQL or either for a while, and does so again."""

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass

import httpx
import pytest

from tests.app.cluster import servers as processes
from tests.app.cluster.forwarder import Forwarder, forwarding, over_file, over_tcp, until_held
from tests.app.cluster.servers import Servers
from tests.app.cluster.test_servers import drop_at, new_room, same_as_alone, until_still
from tests.app.persistence import postgres
from tests.app.relay import redis as tests_redis
from tests.waiting import LIMIT, until

pytestmark = [pytest.mark.postgresql, pytest.mark.long("servers cut off until leases run out")]

TAKEN = (200, 202)


@dataclass
class Divided:
    """Servers, the first of which reaches the others' Redis and PostgreSQL by lines of its own."""

    servers: Servers
    lines: dict[str, Forwarder]


@pytest.fixture(scope="module")
def apart(postgresql: postgres.Cluster) -> Iterator[Divided]:
    if tests_redis.PROGRAM is None:
        pytest.skip(tests_redis.MISSING)
    database = postgresql.new_database()
    name = database.partition("@/")[2].partition("?")[0]
    with contextlib.ExitStack() as stack:
        redis = stack.enter_context(tests_redis.running())
        leases = stack.enter_context(forwarding(over_tcp(redis.port)))
        ledger = stack.enter_context(forwarding(over_file(f"{postgresql.folder}/.s.PGSQL.5432")))
        first = processes.One(
            "plinko1",
            redis=f"redis://127.0.0.1:{leases.port}",
            database=f"postgresql://plinko@127.0.0.1:{ledger.port}/{name}",
        )
        all_of_them = (first, processes.One("plinko2"), processes.One("plinko3"))
        servers = Servers(redis, database, all_of_them)
        stack.enter_context(processes.kept(servers))
        yield Divided(servers, {"redis": leases, "postgresql": ledger})


@pytest.mark.parametrize("lost", [("redis",), ("postgresql",), ("redis", "postgresql")])
def test_a_server_that_is_cut_off_loses_nothing_and_harms_nothing_when_it_is_back(
    apart: Divided, lost: tuple[str, ...]
) -> None:
    servers = apart.servers
    first, second, third = servers.all
    room = new_room(first)
    told = {drop_at(first, room, 70)["ball"]: 70}
    lines = [apart.lines[name] for name in lost]
    for line in lines:
        line.held = 0
        line.cut()
    try:
        answer = httpx.post(
            f"{first.url}/api/v1/rooms/{room}/drops", json={"seed": "71"}, timeout=LIMIT
        )
        if answer.status_code in TAKEN:
            told[answer.json()["ball"]] = 71
        assert answer.status_code not in TAKEN or "postgresql" not in lost
        for line in lines:
            until_held(line)
        if "redis" in lost:
            until(lambda: any(servers.has(one, room) for one in (second, third)))
            told[drop_at(second, room, 72)["ball"]] = 72
    finally:
        for line in lines:
            line.heal()
    until(
        lambda: all(servers.known_to(one) == {"plinko1", "plinko2", "plinko3"} for one in servers)
    )
    until(lambda: first.get("/readyz").status_code == 200)
    if "redis" in lost:
        until(lambda: not servers.has(first, room))
    for number, one in enumerate(servers):
        told[drop_at(one, room, 80 + number)["ball"]] = 80 + number
    until_still(third, room)
    logs = [one.get(f"/api/v1/rooms/{room}/log").json()["drops"] for one in servers]
    assert logs[0] == logs[1] == logs[2]
    seeds = [int(each["seed"]) for each in logs[0]]
    assert {ball: seeds[ball] for ball in told} == told, "what was told is so"
    assert len(set(seeds)) == len(seeds), "nothing came in twice"
    assert set(seeds) <= {*told.values(), 71}
    for each, seed in zip(logs[0], seeds, strict=True):
        assert same_as_alone(each["result"], seed)
