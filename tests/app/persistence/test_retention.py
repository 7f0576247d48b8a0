"""Old drops go while their rooms are played in; what counts them and proves others stays."""

import asyncio
import time
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa

from plinko.app.cli import main
from plinko.app.errors import SettingError
from plinko.app.live.retention import Retention
from plinko.app.persistence.statements import tables
from plinko.app.settings import Settings
from tests.app.persistence.conftest import on_sqlite_first
from tests.app.persistence.crash.life import look
from tests.app.persistence.test_restoring import House, Session, Visit, failures, independently
from tests.kit.serving import serving

DAY = 86_400.0
DROPS = 5


@pytest.fixture
def house(url: str, tmp_path: Path) -> House:
    return House(url, tmp_path)


def sweep(visit: Visit, days: float) -> int:
    """Delete all that is older than a day, `days` later."""
    services = visit.server.services

    async def rest(_: float) -> None:
        await asyncio.sleep(0)

    def later() -> float:
        return time.time() + days * DAY

    sweeper = Retention(services.ledger, services.fair, 1.0, now=later, sleep=rest)
    loop: Any = services.ledger._loop
    return asyncio.run_coroutine_threadsafe(sweeper.sweep(), loop).result()


def drop(visit: Visit, room: str, times: int = 1) -> list[int]:
    body = {"who": "ann"}
    return [visit.post(f"/rooms/{room}/drops?wait=1", body)["ball"] for _ in range(times)]


def drops_of(house: House) -> list[tuple[int, int]]:
    """Room run and ball of each drop of the ledger."""
    row = tables.drops.c
    chosen = sa.select(row.room, row.ball).order_by(row.room, row.ball)
    found = look(house.url, lambda connection: connection.execute(chosen).all())
    return [(run, ball) for run, ball in found]


def test_old_drops_of_open_rooms_go_and_play_goes_on(house: House) -> None:
    with house.open() as visit:
        room, _ = visit.room()
        assert drop(visit, room, DROPS) == list(range(DROPS))
        before = visit.http.get(f"/rooms/{room}").json()["stats"]
        assert sweep(visit, days=0.0) == 0, "nothing is a day old"
        assert sweep(visit, days=2.0) == DROPS - 1, "the next drop continues the last one"
        assert drop(visit, room) == [DROPS]
        after = visit.http.get(f"/rooms/{room}").json()["stats"]
        assert after["drops"] == before["drops"] + 1
        log = visit.http.get(f"/rooms/{room}/log")
        assert (log.status_code, log.json()["code"]) == (410, "pruned")
        assert f"first={DROPS - 1}" in log.json()["detail"]
        part = visit.http.get(f"/rooms/{room}/log", params={"first": DROPS - 1}).json()
        assert [each["ball"] for each in part["drops"]] == [DROPS - 1, DROPS]
        plays = visit.http.get("/players/ann/plays").json()["plays"]
        assert len(plays) == 2
    assert house.ledger("check") == 0
    with house.open() as visit:
        assert visit.http.get(f"/rooms/{room}").json()["stats"] == after
        assert drop(visit, room) == [DROPS + 1]


def test_the_drops_of_an_open_session_stay_until_it_ends(house: House) -> None:
    with house.open() as visit:
        room, _ = visit.room()
        session, other = visit.session(room), visit.session(room)
        heard = [visit.drop(session), visit.drop(other), visit.drop(session)]
        visit.end(other)
        drop(visit, room)
        assert sweep(visit, days=2.0) == 1
        visit.drop(session)
        visit.end(session)
        export = visit.export(session, heard[0], heard[2])
        assert failures(export) == set()
        assert independently(export) == []
        gone = visit.http.get(f"/sessions/{other.id}/export", headers=other.shown)
        assert (gone.status_code, gone.json()["code"]) == (410, "pruned")
        assert sweep(visit, days=2.0) == 3
    assert house.ledger("check") == 0


@on_sqlite_first
def test_the_log_still_proves_receipts_when_earlier_ones_are_gone(house: House) -> None:
    with house.open() as visit:
        room, _ = visit.room()
        early, late = visit.session(room), visit.session(room)
        first = visit.drop(early)
        visit.end(early)
        kept = visit.export(early, first)
        drop(visit, room)
        size = visit.log()["head"]["statement"]["size"]
        assert sweep(visit, days=2.0) == 1
        assert visit.log()["head"]["statement"]["size"] == size
        heard = visit.drop(late)
        visit.end(late)
        assert failures(visit.export(late, heard)) == set()
        assert failures(kept) == set(), "an export from before stays provable"
        proof = visit.http.get("/log", params={"since": size}).json()
        assert proof["head"]["statement"]["size"] == size + 1
        assert proof["consistency"]


@on_sqlite_first
def test_a_session_that_nobody_uses_any_more_ends_and_goes(house: House) -> None:
    with house.open() as visit:
        room, _ = visit.room()
        session = visit.session(room)
        visit.drop(session)
        drop(visit, room)
        visit.server.services.fair._rest = -1.0  # every session is unused for too long
        assert sweep(visit, days=2.0) == 1
        path = f"/sessions/{session.id}"
        assert visit.http.get(path, headers=session.shown).json()["ended"] is True


def test_a_closed_room_goes_with_all_that_it_had(house: House) -> None:
    with house.open() as visit:
        room, owner = visit.room()
        session: Session = visit.session(room)
        visit.drop(session)
        visit.end(session)
        visit.http.put(f"/rooms/{room}/show", json={}, headers=owner).raise_for_status()
        visit.http.delete(f"/rooms/{room}", headers=owner).raise_for_status()
        assert visit.http.get(f"/rooms/{room}/log").status_code == 200
        assert sweep(visit, days=2.0) == 1
        assert visit.http.get(f"/rooms/{room}/log").status_code == 404
    assert drops_of(house) == []
    shows = sa.select(sa.func.count()).select_from(tables.shows)
    assert look(house.url, lambda connection: connection.scalar(shows)) == 0


@on_sqlite_first
def test_prune_of_a_stopped_server_deletes_the_same(house: House) -> None:
    with house.open() as visit:
        room, _ = visit.room()
        drop(visit, room, DROPS)
    ((run, _), *_) = drops_of(house)
    assert house.ledger("prune", "--keep-days", "0", "--dry-run") == 0
    assert len(drops_of(house)) == DROPS
    assert house.ledger("prune", "--keep-days", "0") == 0
    assert drops_of(house) == [(run, DROPS - 1)]


def test_keys_of_requests_go_after_a_week_and_are_new_again(house: House) -> None:
    with house.open() as visit:
        room, _ = visit.room()

        def keyed() -> int:
            path, headers = f"/rooms/{room}/drops", {"idempotency-key": "K"}
            ball: int = visit.post(path, {}, headers=headers)["ball"]
            return ball

        assert [keyed(), keyed()] == [0, 0]
        sweep(visit, days=0.0)
        assert keyed() == 0
        sweep(visit, days=7.1)
        assert keyed() == 1


def test_an_erased_player_leaves_drops_that_say_nothing_of_them(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PLINKO_OPERATOR_TOKEN", "o" * 40)
    settings = {"operator_token": "o" * 40, "data": str(house.folder)}
    with (
        serving(database_url=house.url, **settings) as server,
        server.client("/api/v1") as http,
    ):
        visit = Visit(http, server)
        room, owner = visit.room()
        body = {"who": "ann", "name": "Ann", "colour": "#00ff00"}
        for _ in range(3):
            visit.post(f"/rooms/{room}/drops?wait=1", body, headers=owner)
        visit.post(f"/rooms/{room}/drops?wait=1", {"who": "ben"})
        before = http.get(f"/rooms/{room}/log").json()
        assert main(["players", "erase", "ann", server.url]) == 0
        assert http.get("/players/ann/plays").json()["plays"] == []
        assert len(http.get("/players/ben/plays").json()["plays"]) == 1
        after = http.get(f"/rooms/{room}/log", headers=owner).json()
        assert [each["who"] for each in after["drops"]] == [None, None, None, "ben"]
        assert not any("name" in each or "colour" in each for each in after["drops"])
        results = [[each["result"] for each in log["drops"]] for log in (before, after)]
        assert results[0] == results[1]
        assert http.get(f"/rooms/{room}/log").json()["digest"] == before["digest"]
        monkeypatch.setenv("PLINKO_OPERATOR_TOKEN", "x" * 40)
        assert main(["players", "erase", "ben", server.url]) == 2
    assert house.ledger("check") == 0


@pytest.mark.parametrize("days", [0.5, -1.0])
def test_a_time_under_a_day_is_refused(days: float) -> None:
    with pytest.raises(SettingError, match="retention"):
        Settings(retention=days)
