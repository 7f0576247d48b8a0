"""A room can be closed or reset at once, however long its balls would fall: they land first."""

import json

from benchmarks.scenes.expensive_boards import hall
from plinko.app.rooms.log import verify_log
from plinko.engine import Board, drop
from tests.kit.serving import serving


def test_a_ball_that_bounces_for_minutes_holds_up_no_end() -> None:
    with serving() as server, server.client("/api/v1") as http:
        for how in ("close", "reset"):
            made = http.post("/rooms", json={"board": hall()}).raise_for_status().json()
            bearer = {"authorization": f"Bearer {made['token']}"}
            room = f"/rooms/{made['id']}"
            # One seed in ten lands, some of them soon. This one bounces for 15 minutes.
            http.post(f"{room}/drops", json={"seed": "0"}, headers=bearer).raise_for_status()
            if how == "reset":
                http.post(f"{room}/reset", headers=bearer).raise_for_status()
                http.post(f"{room}/drops", json={"seed": "4"}, headers=bearer).raise_for_status()
                assert http.get(room).json()["awake"]
                continue
            http.delete(room, headers=bearer).raise_for_status()
            log = http.get(f"{room}/log").json()
    (entry,) = log["drops"]
    alone = drop(Board.from_json(json.dumps(hall())), 0)
    assert entry["result"]["digest"] == alone.digest
    assert entry["result"]["t"] == alone.duration > 600
    assert verify_log(log).ok
