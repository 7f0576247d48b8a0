"""A player's last plays, by the player's mark: with links to the drops' paths, in pages."""

import csv
import io
import json
import time
import urllib.parse
from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.app.conftest import QUICK
from tests.app.live.sessions.test_fair_sessions import begun
from tests.kit.serving import serving
from tests.kit.waiting import until

BOARD = {**QUICK, "drop": {"x": 0.0, "y": 0.0, "jitter": 0.25, "reach": 0.5, "aim": 0.25}}
MARK = "mark of nobody else"
PLAYS = f"/api/v1/players/{MARK}/plays"


def played(http: httpx.Client, room: str, *, wait: int = 1, **body: Any) -> dict[str, Any]:
    answer = http.post(f"/api/v1/rooms/{room}/drops", params={"wait": wait}, json=body)
    assert answer.status_code in (200, 202), answer.text
    found: dict[str, Any] = answer.json()
    return found


def recalled(http: httpx.Client, **query: Any) -> dict[str, Any]:
    answer = http.get(PLAYS, params=query)
    assert answer.status_code == 200, answer.text
    found: dict[str, Any] = answer.json()
    return found


@pytest.fixture(scope="module")
def rooms(http: httpx.Client) -> tuple[str, str]:
    """Two rooms; the second has four plays of the player, and plays of others."""
    first, second = (http.post("/api/v1/rooms", json={"board": BOARD}).json()["id"] for _ in "ab")
    session, shown = begun(http, second)
    staked = {"stake": 100, "session": session["session"], "who": MARK}
    for number in range(3):
        played(http, second, wait=0, seed=str(number), who=MARK)
        played(http, second, wait=0, seed=str(number), who="another")
    address = f"/api/v1/rooms/{second}/drops"
    answer = http.post(address, params={"wait": 1}, json=staked, headers=shown)
    assert answer.json().get("landed"), answer.text
    until(lambda: http.get(f"/api/v1/rooms/{second}").json()["balls"] == [])
    return first, second


def test_the_last_play_comes_first_with_total_stake_and_payout(
    http: httpx.Client, rooms: tuple[str, str]
) -> None:
    last = recalled(http, limit=1)["plays"][0]
    assert (last["room"], last["board"], last["stake"]) == (rooms[1], "quick", 100)
    assert last["payout"] == 100 * last["score"]
    assert last["session_drop"] == 0
    assert abs(last["time"] / 1000.0 - time.time()) < 3600.0
    first = recalled(http)["plays"][-1]
    start = {"seed": "0", "practice": True, "stake": 0, "session": None}
    assert start.items() <= first.items()


def test_the_best_plays_of_a_day_paid_most(http: httpx.Client) -> None:
    tiny: Any = QUICK
    bins = {**tiny["bins"], "multipliers": [12.0, 12.0]}
    room = http.post("/api/v1/rooms", json={"board": {**BOARD, "bins": bins}}).json()["id"]
    best = f"/api/v1/rooms/{room}/best"
    assert http.get(best).json() == {"plays": [], "next": None}
    session, shown = begun(http, room)
    for stake in (100, 300, 200):
        body = {"stake": stake, "session": session["session"]}
        address = f"/api/v1/rooms/{room}/drops"
        answer = http.post(address, params={"wait": 1}, json=body, headers=shown)
        assert answer.json().get("landed"), answer.text
    played(http, room, seed="1")  # practice
    found = http.get(best).json()["plays"]
    paid = [(play["stake"], play["payout"]) for play in found]
    assert paid == [(300, 3600), (200, 2400), (100, 1200)]
    other = http.post("/api/v1/rooms", json={"board": BOARD}).json()["id"]
    played(http, other, seed="1")
    assert http.get(f"/api/v1/rooms/{other}/best").json()["plays"] == [], "multipliers below 10"
    assert http.get("/api/v1/rooms/nowhere/best").status_code == 404


def test_pages_follow_one_another_and_a_play_s_path_is_its_own_to_the_last_bit(
    http: httpx.Client, rooms: tuple[str, str]
) -> None:
    whole = recalled(http)
    plays = whole["plays"]
    assert (len(plays), whole["next"]) == (4, None)
    page = recalled(http, limit=2)
    rest = recalled(http, limit=2, before=page["next"])
    assert (page["plays"] + rest["plays"], rest["next"]) == (plays, None)
    for play in plays:
        path = http.get(play["path"]).json()
        assert path["digest"] == play["digest"]
        assert path["impacts"][-1][0] == play["duration"]
        assert (path["bin"], path["x_end"]) == (play["bin"], play["x_end"])


def test_plays_as_csv_say_the_same(http: httpx.Client, rooms: tuple[str, str]) -> None:
    answer = http.get(PLAYS, params={"limit": 2}, headers={"accept": "text/csv"})
    assert answer.headers["content-type"].startswith("text/csv")
    assert answer.content.startswith(b"\xef\xbb\xbf"), "spreadsheets know UTF-8 by this mark"
    rows = table_of(answer)
    told = recalled(http, limit=2)["plays"]
    assert [*rows[0]] == [*told[0]]
    for row, play in zip(rows, told, strict=True):
        texts = {name: "" if value is None else str(value) for name, value in play.items()}
        practice = "true" if play["practice"] else "false"
        numbers = {name: f"'{play[name]}" for name in ("seed", "play")}
        assert row == {**texts, **numbers, "practice": practice}
    following = answer.links["next"]["url"]
    rest = http.get(following, params={"format": "csv"} | dict(httpx.URL(following).params))
    assert len(table_of(rest)) == 2
    assert http.get(PLAYS, params={"format": "json"}, headers={"accept": "text/csv"}).json()


@pytest.mark.parametrize("mark", ["Zoë 日本", "a>b; rel=x", "100% &?#", "ü"])
def test_plays_as_csv_are_those_of_any_mark_and_link_to_the_rest(
    http: httpx.Client, rooms: tuple[str, str], mark: str
) -> None:
    for seed in range(3):
        played(http, rooms[0], seed=seed, who=mark)
    address = f"/api/v1/players/{urllib.parse.quote(mark, safe='')}/plays"
    answer = http.get(address, params={"limit": 2, "format": "csv"})
    assert answer.status_code == 200, answer.text
    following = answer.links["next"]["url"]
    assert following.isascii()
    rest = http.get(following)
    assert rest.headers["content-type"].startswith("text/csv")
    seeds = [row["seed"] for page in (answer, rest) for row in table_of(page)]
    assert seeds == ["'2", "'1", "'0"], "no spreadsheet rounds them"


TAKEN = ["=1+1", "+1", "-1", "@SUM(A1)", "1e5", "12.50", ".5", "18446744073709551615"]


def test_a_cell_of_csv_is_text_and_no_formula_or_number(http: httpx.Client) -> None:
    for name in (*TAKEN, "\u2212 plain", "1e5 balls", "e5", "1.2.3"):
        board = {**BOARD, "name": name}
        room = http.post("/api/v1/rooms", json={"board": board}).json()["id"]
        played(http, room, seed=1, x=-0.125, who="calculator")
        plays = http.get("/api/v1/players/calculator/plays", params={"format": "csv"})
        row = table_of(plays)[0]
        assert row["board"] == (f"'{name}" if name in TAKEN else name)
        assert row["x"] == "-0.125", "a number stays one"


def table_of(answer: httpx.Response) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(answer.content.decode("utf-8-sig"))))


def test_an_unused_mark_has_no_plays_and_an_invalid_one_is_named(http: httpx.Client) -> None:
    assert http.get("/api/v1/players/nobody/plays").json() == {"plays": [], "next": None}
    for query, named in (({"before": "1"}, "before '1'"), ({"limit": 101}, "limit")):
        answer = http.get(PLAYS, params=query)
        assert answer.status_code == 422
        assert named in answer.json()["detail"]


def test_plays_and_their_paths_outlive_the_server(tmp_path: Path) -> None:
    board = tmp_path / "tiny.json"
    board.write_text(json.dumps(BOARD))
    url = f"sqlite:///{tmp_path / 'plinko.db'}"
    first = serving(database_url=url, board=str(board))
    with first as server, server.client() as http:
        played(http, "main", seed="5", x=0.25, who=MARK)
        before = recalled(http)
    # The next server has another main board: only the ledger knows this one.
    second = serving(database_url=url, board="triangle-8")
    with second as server, server.client() as http:
        assert recalled(http) == before
        (play,) = before["plays"]
        assert http.get(play["path"]).json()["digest"] == play["digest"]
        assert play["x"] == 0.25


def test_a_room_recalls_the_plays_of_all_since_it_was_reset(http: httpx.Client) -> None:
    made = http.post("/api/v1/rooms", json={"board": BOARD}).raise_for_status().json()
    address, owner = f"/api/v1/rooms/{made['id']}", {"authorization": f"Bearer {made['token']}"}
    played(http, made["id"], seed="1")
    http.post(f"{address}/reset", headers=owner).raise_for_status()
    for name in ("Ann", "=1+1"):
        body = {"name": name, "colour": "#00ff00"}
        http.post(f"{address}/drops?wait=1", json=body, headers=owner).raise_for_status()
    first = http.get(f"{address}/plays", params={"limit": 1})
    assert [play["name"] for play in first.json()["plays"]] == ["=1+1"]
    following = http.get(first.links["next"]["url"]).json()
    assert ([play["name"] for play in following["plays"]], following["next"]) == (["Ann"], None)
    table = table_of(http.get(f"{address}/plays", params={"format": "csv", "limit": 1000}))
    rows = [(row["name"], row["colour"]) for row in table]
    assert rows == [("'=1+1", "#00ff00"), ("Ann", "#00ff00")]
    assert all(row["bin"] for row in table)
    assert http.get("/api/v1/rooms/nope/plays").status_code == 404


def test_a_room_s_table_says_what_each_ball_has_won(http: httpx.Client) -> None:
    bins: Any = QUICK["bins"]
    labels = [{"text": f"prize {number}"} for number in range(len(bins["multipliers"]))]
    board = {**QUICK, "bins": {**bins, "labels": labels}}
    room = http.post("/api/v1/rooms", json={"board": board}).json()["id"]
    landed = played(http, room, seed="7")["landed"]
    address = f"/api/v1/rooms/{room}/plays"
    (row,) = table_of(http.get(address, params={"format": "csv"}))
    assert row["label"] == landed["label"] == f"prize {landed['bin']}"
    (play,) = http.get(address).json()["plays"]
    assert play["label"] == landed["label"]
