"""A draw survives a restart: its weights, seeds, sessions and names are unchanged."""

from pathlib import Path
from typing import Any

import httpx
import pytest

from plinko.app.errors import DamagedRoomError
from plinko.app.persistence import room_runs
from plinko.app.persistence.ledger.database import Database
from plinko.app.persistence.recovery.rebuild import basis_of
from plinko.app.persistence.statements import store, totals
from plinko.app.rooms.draw import Draw
from plinko.app.rooms.kinds import DRAW
from plinko.app.rooms.records import StoredBasis
from plinko.engine import PHYSICS_VERSION, Board, find_draw
from tests.app.conftest import QUICK
from tests.app.live.sessions.test_fair_sessions import begun, checked
from tests.app.persistence.conftest import on_sqlite, on_sqlite_first
from tests.app.persistence.crash.life import living, look
from tests.kit.serving import constants, serving

BOARD = Board.from_json(QUICK)
PREPARED = find_draw(BOARD, [2, 1], per_bin=3)
OVER = Draw.of(BOARD, **PREPARED)


def dropped(http: httpx.Client, room: str, session: str, shown: dict[str, str]) -> dict[str, Any]:
    body = {"session": session, "stake": 100}
    drops = f"/api/v1/rooms/{room}/drops"
    answer = http.post(drops, params={"wait": 1}, json=body, headers=shown)
    assert answer.status_code == 200, answer.text
    landed: dict[str, Any] = answer.json()["landed"]
    return landed


@on_sqlite_first
def test_a_session_of_a_draw_goes_on_after_a_restart(url: str, tmp_path: Path) -> None:
    settings: dict[str, Any] = {"database_url": url, "data": str(tmp_path)}
    taken_by_1_0 = {"plinko.app.rooms.independent.DrawRoom.takes_stakes": True}
    with constants(**taken_by_1_0), serving(**settings) as server, server.client() as http:
        body = {"board": QUICK, "mode": "draw", "draw": PREPARED}
        room = http.post("/api/v1/rooms", json=body).json()
        session, shown = begun(http, room["id"])
        before = [dropped(http, room["id"], session["session"], shown) for _ in range(2)]
    with constants(**taken_by_1_0), serving(**settings) as server, server.client() as http:
        place = f"/api/v1/rooms/{room['id']}"
        assert http.get(place).json()["draw"] == room["draw"]
        assert http.get(f"{place}/draw").json() == OVER.to_dict()
        after = dropped(http, room["id"], session["session"], shown)
        assert all(each["seed"] in PREPARED["seeds"][each["bin"]] for each in [*before, after])
        http.post(f"/api/v1/sessions/{session['session']}/end", headers=shown)
        key = checked(http, session["session"], shown)
        assert (key.failed, key.drops) == ([], 3)
        assert http.delete(place, headers={"authorization": f"Bearer {room['token']}"}).is_success
        assert checked(http, session["session"], shown).ok, "an export needs no open room"
    database = Database(url)
    database.open()
    with database.transaction() as connection:
        assert totals.read(connection) == [], "a draw's odds do not count for the board"
    database.close()


@on_sqlite
async def test_a_draw_of_another_physics_ends(url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its seeds may land in other bins now, so the room ends."""
    monkeypatch.setattr(room_runs, "PHYSICS_VERSION", PHYSICS_VERSION - 1)
    async with living(url) as life:
        room = await life.rooms.create(OVER, DRAW)
        await life.leave()
    monkeypatch.undo()
    async with living(url) as life:
        await life.back()
        assert await life.rooms.persistence.recovery.load(room.id) is None
        await life.leave()
    assert look(url, store.open_room, room.id) is None


@on_sqlite
async def test_a_damaged_draw_is_named(url: str) -> None:
    async with living(url) as life:
        room = await life.rooms.create(OVER, DRAW)
        row = await life.row(room.id)
        await life.leave()
    kept = look(url, store.basis, row.board, row.draw)
    found = basis_of(row, kept)
    assert isinstance(found, Draw)
    assert found.digest == OVER.digest
    lighter = OVER.to_json().decode().replace('"weights":[2,1]', '"weights":[1,1]')
    for damaged, what in ((None, "missing"), ("{}", "is invalid"), (lighter, "has digest")):
        with pytest.raises(DamagedRoomError, match=f"its draw {OVER.digest} .*{what}"):
            basis_of(row, StoredBasis(kept.board, damaged))
