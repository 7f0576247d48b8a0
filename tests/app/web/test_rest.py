"""Boards, drops and rooms over HTTP: right answers, and clear errors."""

from typing import Any
from unittest import mock

import httpx
import msgspec
import pytest

from plinko.app.protocol.messages import Landed
from plinko.engine import Board, drop, drop_many, preset_names
from plinko.engine.board import presets
from plinko.engine.payouts import listing
from plinko.engine.payouts.landings import aims_of
from plinko.engine.payouts.record import odds_of_record
from tests.app.conftest import QUICK, TINY
from tests.kit.problems import problem
from tests.kit.serving import constants, serving
from tests.kit.waiting import until

BOARD = Board.preset("triangle-16")


# Boards.


def test_every_preset_is_listed_with_its_digest_and_payouts(http: httpx.Client) -> None:
    boards = {board["name"]: board for board in http.get("/api/v1/boards").json()["boards"]}
    assert set(preset_names()) <= set(boards)
    high = boards["triangle-12-high"]
    assert (high["rows"], high["risk"], high["bins"]) == (12, "high", 13)
    assert high["digest"] == Board.preset("triangle-12-high").digest
    assert high["multipliers"] == list(Board.preset("triangle-12-high").bins.multipliers)
    assert boards["triangle-16"]["risk"] == "medium"
    assert (boards["classic"]["rows"], boards["classic"]["risk"]) == (None, None)
    assert (high["stakes"], high["world"], high["top_multiplier"]) == (True, "house", 165.0)
    assert high["return"] == odds_of_record(Board.preset("triangle-12-high"))[0].returned
    moon = boards["moon-16-low"]
    assert (moon["stakes"], moon["world"], moon["rows"], moon["risk"]) == (True, "moon", 16, "low")
    unstaked = [name for name, each in boards.items() if each["preset"] and not each["stakes"]]
    assert unstaked == ["galton"]


def test_the_list_of_boards_lays_out_no_board(http: httpx.Client) -> None:
    """There are hundreds; each takes milliseconds."""
    listing.listed.cache_clear()
    with mock.patch.object(presets, "triangle") as layout:
        assert len(http.get("/api/v1/boards").json()["boards"]) >= len(preset_names())
    assert layout.call_count == 0


def test_a_board_is_found_by_name_and_by_digest(http: httpx.Client) -> None:
    by_name = http.get("/api/v1/boards/triangle-16").json()
    assert by_name == http.get(f"/api/v1/boards/{BOARD.digest}").json()
    assert Board.from_json(by_name["board"]) == BOARD


def test_a_board_is_checked_without_being_kept_and_registered_once(http: httpx.Client) -> None:
    board = {**TINY, "name": "registered twice"}
    checked = http.post("/api/v1/boards/check", json=board)
    assert checked.status_code == 200
    whole = Board.from_json(board)
    digest = whole.digest
    form = {"name": "registered twice", "digest": digest, "board": whole.to_dict()}
    assert checked.json() == form
    assert http.get(f"/api/v1/boards/{digest}").status_code == 404
    first = http.post("/api/v1/boards", json=board)
    assert (first.status_code, first.content) == (201, checked.content)
    assert first.headers["location"] == f"/api/v1/boards/{digest}"
    second = http.post("/api/v1/boards", json=board)
    assert (second.status_code, second.json()) == (200, first.json())
    listed = http.get("/api/v1/boards").json()["boards"]
    assert [entry["digest"] for entry in listed].count(digest) == 1
    record = http.get(f"/api/v1/drops/{digest}/42").json()
    assert record["digest"] == drop(whole, 42).digest
    # A preset is registered already.
    again = http.post("/api/v1/boards", json=BOARD.to_dict())
    assert (again.status_code, again.json()["digest"]) == (200, BOARD.digest)
    listed = http.get("/api/v1/boards").json()["boards"]
    assert [entry["digest"] for entry in listed].count(BOARD.digest) == 1


def test_a_worker_encodes_a_board_and_the_server_its_room_s_copy(
    http: httpx.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, form = [], Board.to_dict

    def counted(board: Board) -> dict[str, Any]:
        made.append(board.name)
        return form(board)

    monkeypatch.setattr(Board, "to_dict", counted)
    board = {**TINY, "name": "large, say"}
    registered = http.post("/api/v1/boards", json=board)
    assert registered.status_code == 201
    assert made == [], "this process, in which rooms tick, has the worker's bytes"
    found = Board.from_json(registered.json()["board"])
    assert registered.json()["digest"] == found.digest
    opened = http.post("/api/v1/rooms", json={"board": board}).raise_for_status().json()
    assert opened["board_digest"] == found.digest
    assert made == ["large, say"], "for spectators and for the ledger alike"


def test_too_many_boards_push_out_the_longest_unused() -> None:
    with (
        constants(**{"plinko.app.main.MAX_BOARDS": 2}),
        serving() as server,
        server.client() as http,
    ):
        digests = [
            http.post("/api/v1/boards", json={**TINY, "name": name}).json()["digest"]
            for name in ("a", "b")
        ]
        assert http.get(f"/api/v1/boards/{digests[0]}").status_code == 200
        http.post("/api/v1/boards", json={**TINY, "name": "c"})
        assert http.get(f"/api/v1/boards/{digests[0]}").status_code == 200
        problem(http.get(f"/api/v1/boards/{digests[1]}"), 404, "unknown-board")


# Drops.


def test_the_odds_of_a_preset_are_those_of_record_by_aim(http: httpx.Client) -> None:
    found = http.get("/api/v1/boards/triangle-9/odds").json()
    board = Board.preset("triangle-9")
    assert found["board_digest"] == board.digest
    own, *others = found["aims"]
    assert own["aim"] is None
    assert own["return"] == odds_of_record(board)[0].returned
    assert own["awards"][0]["multiplier"] == max(board.bins.multipliers)
    assert [each["aim"] for each in others] == list(aims_of(board)[1:])


def test_decimals_are_taken_as_people_write_them_and_a_seed_is_drawn(http: httpx.Client) -> None:
    for x in ("0.05", "-0.05", "+0.05", ".05", "5e-2", "5E-02", "0"):
        found = http.get("/api/v1/drops/triangle-8/42", params={"x": x})
        assert found.json()["x"] == float(x)
    # Without a seed the server draws one, and says which.
    asked = {"board": "triangle-16"}
    first, second = (http.post("/api/v1/drops", json=asked).json() for _ in range(2))
    assert first["seed"] != second["seed"]
    assert first["digest"] == drop(BOARD, first["seed"]).digest


def test_a_drop_s_etag_is_its_digest_and_a_current_copy_is_not_sent_again(
    http: httpx.Client,
) -> None:
    path = "/api/v1/drops/triangle-16/42"
    response = http.get(path)
    etag = f'"{drop(BOARD, 42).digest}"'
    assert response.headers["etag"] == f"W/{etag}", "it is compressed"
    assert "public" in response.headers["cache-control"]
    assert http.get(path, headers={"accept-encoding": "identity"}).headers["etag"] == etag
    for tag in (etag, f"W/{etag}", f'"other", {etag}', "*"):
        response = http.get(path, headers={"if-none-match": tag})
        assert (response.status_code, response.content) == (304, b"")
        assert response.headers["etag"].removeprefix("W/") == etag
    assert http.get(path, headers={"if-none-match": '"other"'}).status_code == 200


def test_frames_are_states_at_their_rate_and_at_the_landing(http: httpx.Client) -> None:
    done = drop(BOARD, 42)
    body = http.get("/api/v1/drops/triangle-16/42/frames?fps=30").json()
    assert (body["digest"], body["duration"], body["fps"]) == (done.digest, done.duration, 30.0)
    assert body["fields"] == ["t", "x", "y", "theta", "vx", "vy", "omega"]
    times = [frame[0] for frame in body["frames"]]
    assert times[:-1] == [k / 30 for k in range(len(times) - 1)]
    assert times[-1] == done.duration
    assert body["frames"] == [list(row) for row in done.states(times).tolist()]


@pytest.mark.parametrize("solver", ["exact", "stepped"])
def test_frames_have_the_state_right_before_each_impact(http: httpx.Client, solver: str) -> None:
    """The speeds before and after each free impact obey the material's law up to rounding."""
    path = "/api/v1/drops/triangle-16/42"
    record = http.get(f"{path}?solver={solver}").json()
    body = http.get(f"{path}/frames?fps=1&solver={solver}").json()
    assert len(body["before"]) == len(record["impacts"])
    bounces = 0
    for before, after in zip(body["before"], record["impacts"], strict=True):
        t, x, y, _, vx, vy, _ = before
        assert after[0] >= t >= after[0] * (1 - 1e-15) - 1e-300
        assert (x, y) == pytest.approx(after[1:3], abs=1e-9)
        if after[6] != 0:
            continue
        peg = BOARD.pegs[int(after[7])]
        nx, ny = x - peg.x, y - peg.y
        reach = (nx * nx + ny * ny) ** 0.5
        restitution = max(BOARD.peg_material.restitution, BOARD.ball.restitution)
        approach = (vx * nx + vy * ny) / reach
        assert approach < 0.0, "it comes nearer before"
        if solver == "exact":
            away = (after[3] * nx + after[4] * ny) / reach
            assert away == pytest.approx(-restitution * approach, rel=1e-9)
        bounces += 1
    assert bounces > 5


def test_of_two_events_at_one_instant_the_later_starts_there(http: httpx.Client) -> None:
    """A ball with restitution 0 hits a peg and begins to roll on it at the same time."""
    dead = {"restitution": 0.0, "friction": 0.1}
    board = {**TINY, "name": "dead", "ball": dead, "peg_material": dead}
    digest = http.post("/api/v1/boards", json=board).json()["digest"]
    record = http.get(f"/api/v1/drops/{digest}/1?x=0.02").json()
    before = http.get(f"/api/v1/drops/{digest}/1/frames?x=0.02").json()["before"]
    hit, ride = record["impacts"][:2]
    assert (hit[6], ride[6], ride[0]) == (0, 2, hit[0])
    t, x, y, _, vx, vy, omega = before[1]
    assert [t, x, y, vx, vy, omega] == hit[:6]


# Many drops.


def test_many_drops_are_counted_as_the_command_line_counts_them(http: httpx.Client) -> None:
    asked = {"board": "triangle-8", "drops": 250, "seed": "7"}
    body = http.post("/api/v1/simulate", json=asked).json()
    batch = drop_many(Board.preset("triangle-8"), range(7, 257))
    assert body == {
        "board_digest": batch.board.digest,
        "drops": 250,
        "histogram": batch.histogram.tolist(),
        "unsettled": batch.unsettled_count,
        "mean_duration": pytest.approx(batch.duration.mean()),
        "mean_impacts": pytest.approx(batch.impact_count.mean()),
        "digest": batch.digest,
    }
    # A board and the stepped solver may be given.
    asked = {"board": TINY, "drops": 20, "solver": "stepped", "dt": 0.01, "substeps": 2}
    body = http.post("/api/v1/simulate", json=asked).json()
    board = Board.from_json(TINY)
    batch = drop_many(board, range(20), solver="stepped", dt=0.01, substeps=2)
    assert (body["board_digest"], body["digest"]) == (board.digest, batch.digest)


# Seeds by bin.


def test_seeds_are_found_in_parts_that_leave_none_out(http: httpx.Client) -> None:
    bins = drop_many(Board.preset("triangle-8"), 400).bin
    wanted = [str(seed) for seed in range(400) if bins[seed] == 2]
    asked = {"board": "triangle-8", "bin": 2, "count": 1000}
    part = http.post("/api/v1/seeds", json=asked | {"drops": 150}).json()
    rest = http.post("/api/v1/seeds", json=asked | {"drops": 250, "after": part["last"]}).json()
    assert (part["last"], rest["last"]) == ("149", "399")
    assert part["seeds"] + rest["seeds"] == wanted
    few = http.post("/api/v1/seeds", json=asked | {"count": 2}).json()
    assert (few["seeds"], few["last"]) == (wanted[:2], wanted[1])
    # No ball comes to this bin.
    straight = {"bins": {"y": 1.0, "edges": [-1, 0, 1]}, "drop": {"x": -0.5, "jitter": 0.1}}
    found = http.post("/api/v1/seeds", json={"board": straight, "bin": 1, "drops": 300}).json()
    assert (found["seeds"], found["last"]) == ([], "299")


# Verification.


def test_a_record_verifies_and_a_changed_one_does_not(http: httpx.Client) -> None:
    record = http.get("/api/v1/drops/triangle-16/42").json()
    assert http.post("/api/v1/verify", json=record).json()["ok"] is True
    changed = {**record, "x_end": record["x_end"] + 1e-9}
    answer = http.post("/api/v1/verify", json=changed)
    verdict = answer.json()
    assert (answer.status_code, verdict["ok"], verdict["field"]) == (200, False, "x_end")
    assert (verdict["expected"], verdict["actual"]) == (changed["x_end"], record["x_end"])


# Rooms.


def test_main_is_always_there_and_a_preset_s_name_is_a_room_opened_on_request(
    http: httpx.Client,
) -> None:
    rooms = {room["id"]: room for room in http.get("/api/v1/rooms").json()["rooms"]}
    assert rooms["main"]["board_name"] == "triangle-16"
    view = http.get("/api/v1/rooms/main").json()
    assert (view["mode"], view["solver"], view["tick_rate"]) == ("independent", "exact", 60)
    view = http.get("/api/v1/rooms/triangle-9-low").json()
    assert (view["id"], view["board_name"]) == ("triangle-9-low", "triangle-9-low")
    ids = [room["id"] for room in http.get("/api/v1/rooms").json()["rooms"]]
    assert ids.count("triangle-9-low") == 1


def test_a_ball_is_dropped_into_a_room_over_any_board_and_can_be_waited_for(
    http: httpx.Client,
) -> None:
    response = http.post("/api/v1/rooms", json={"board": TINY, "mode": "independent"})
    assert response.status_code == 201
    room = response.json()
    place = f"/api/v1/rooms/{room['id']}"
    assert response.headers["location"] == place
    assert len(room.pop("token")) == 43
    assert http.get(place).json() == room
    board = Board.from_json(TINY)
    assert room["board_digest"] == board.digest
    assert http.post("/api/v1/rooms", json={"board": TINY}).json()["id"] != room["id"]
    response = http.post(f"{place}/drops")
    assert response.status_code == 202
    ball = response.json()
    assert (ball["ball"], ball["room"]) == (0, room["id"])
    assert ball["tick"] >= 0  # of the room's clock, which runs since the room was opened
    assert 0 <= int(ball["seed"]) < 2**64
    assert "landed" not in ball
    response = http.post(f"{place}/drops?wait=1", json={"seed": "42"})
    assert response.status_code == 200
    landed = msgspec.convert(response.json()["landed"], Landed)
    alone = drop(board, 42)
    assert (landed.digest, landed.bin) == (alone.digest, alone.bin)
    until(lambda: sum(http.get(place).json()["stats"]["histogram"]) == 2)
    assert http.get(place).json()["stats"]["drops"] == 2


def test_a_prize_is_in_the_landing_the_record_and_the_board(http: httpx.Client) -> None:
    labels = [{"text": f"<b>prize {n}</b>", "colour": "#ff0088"} for n in range(2)]
    bins = Board.from_json(TINY).to_dict()["bins"]
    board = QUICK | {"bins": bins | {"labels": labels}}
    digest = http.post("/api/v1/boards", json=board).json()["digest"]
    assert http.get(f"/api/v1/boards/{digest}").json()["board"]["bins"]["labels"] == labels
    record = http.get(f"/api/v1/drops/{digest}/42").json()
    assert record["label"] == labels[record["bin"]]["text"]
    assert http.post("/api/v1/verify", json=record).json()["ok"]
    room = http.post("/api/v1/rooms", json={"board": digest}).json()["id"]
    reply = http.post(f"/api/v1/rooms/{room}/drops?wait=1", json={"seed": "42"}).json()
    assert reply["landed"]["label"] == record["label"]
    wrong = board | {"bins": bins | {"labels": [{"text": "a\u202eb"}, *labels[1:]]}}
    refused = http.post("/api/v1/boards/check", json=wrong)
    assert (refused.status_code, refused.json()["field"]) == (422, "bins.labels[0].text")


def test_an_idle_room_makes_way_when_all_are_taken_a_busy_not() -> None:
    slow = {"board": TINY | {"gravity": 1e-3}}  # no ball lands during the test
    with (
        constants(**{"plinko.app.live.stored_rooms.REST_SECONDS": 0.0}),
        serving(max_rooms=1) as server,
        server.client() as http,
    ):
        idle = http.post("/api/v1/rooms", json=slow).json()["id"]
        busy = http.post("/api/v1/rooms", json=slow).json()["id"]
        assert http.get(f"/api/v1/rooms/{idle}").status_code == 404
        assert http.post(f"/api/v1/rooms/{busy}/drops").status_code == 202
        problem(http.post("/api/v1/rooms", json=slow), 429, "too-many-rooms", "1")
        assert http.get("/api/v1/rooms/main").status_code == 200


# Health, and what every reply has.


def test_health_and_readiness(http: httpx.Client) -> None:
    health = http.get("/healthz").json()
    assert health["status"] == "ok"
    assert health["ticker"].keys() == {"asleep", "ticks", "wakeups", "overruns", "skipped"}
    ready = http.get("/readyz")
    assert (ready.status_code, ready.json()["ready"]) == (200, True)
    assert all(ready.json()["checks"].values())
    assert "server" not in ready.headers


# The certainty of a drop.


def test_a_drop_says_how_sure_it_is_when_asked(http: httpx.Client) -> None:
    plain = http.get("/api/v1/drops/triangle-8/42").json()
    asked = http.get("/api/v1/drops/triangle-8/42?certainty=true").json()
    expected = drop(Board.preset("triangle-8"), 42)
    assert asked == plain | {
        "amplification": expected.amplification,
        "x_error": expected.certainty.error,
        "certain": expected.certain,
    }
    wanted = {"board": "triangle-8", "seed": "42", "certainty": True}
    assert http.post("/api/v1/drops", json=wanted).json() == asked


def test_an_address_s_rooms_are_limited() -> None:
    with (
        serving(max_rooms=10) as server,
        server.client() as http,
    ):
        body = {"board": "triangle-8"}
        opened = [http.post("/api/v1/rooms", json=body) for _ in range(3)]
        assert [response.status_code for response in opened] == [201, 201, 201]
        refused = http.post("/api/v1/rooms", json=body)
        problem(refused, 429, "room-quota", "3 rooms of this address")
        assert refused.headers["retry-after"] == "1"
        first = opened[0].json()
        headers = {"authorization": f"Bearer {first['token']}"}
        assert http.delete(f"/api/v1/rooms/{first['id']}", headers=headers).status_code == 204
        problem(http.post("/api/v1/rooms", json={"board": "nope"}), 404, "unknown-board")
        assert http.post("/api/v1/rooms", json=body).status_code == 201


def test_a_board_of_too_many_parts_is_refused_unread() -> None:
    board: dict[str, Any] = {"pegs": [{}] * 7, "walls": [{}] * 4}
    with (
        constants(**{"plinko.app.web.routes.common.MAX_SURFACES": 10}),
        serving() as server,
        server.client() as http,
    ):
        for path, body in (
            ("boards", board),
            ("boards/check", board),
            ("rooms", {"board": board}),
            ("drops", {"board": board, "seed": 1}),
        ):
            refused = http.post(f"/api/v1/{path}", json=body)
            problem(refused, 413, "too-large", "11 pegs and walls", "10")
        problem(http.post("/api/v1/boards", json={"pegs": [{}] * 10}), 422, "bad-board")


def test_a_payout_table_is_solved_for_a_board_over_rest(http: httpx.Client) -> None:
    board = Board.preset("triangle-8").to_dict() | {"name": "mine"}
    body = {"board": board, "return": 0.95, "risk": "low", "drops": 1000}
    found = http.post("/api/v1/payouts", json=body).json()
    chose, judge = (
        drop_many(Board.from_json(board), range(first, first + 1000)).histogram
        for first in (0, 1000)
    )
    assert chose @ found["multipliers"] / 1000 == pytest.approx(0.95, abs=6e-4)
    assert found["aims"][0]["return"] == pytest.approx(judge @ found["multipliers"] / 1000)
    assert found["multipliers"] == found["multipliers"][::-1]
    assert found["chosen_by"] == found["drops"] == 1000


def test_all_faults_of_a_board_are_named_at_once(http: httpx.Client) -> None:
    board = {"gravity": -1.0, "pegs": [{"x": 0.0, "y": 1.0}], "drag": -1.0}
    for path, body in (("boards", board), ("boards/check", board), ("drops", {"board": board})):
        refused = http.post(f"/api/v1/{path}", json=body)
        problem(refused, 422, "bad-board", "pegs[0].radius", "gravity", "drag")
        faults = refused.json()["faults"]
        assert [fault["field"] for fault in faults] == ["pegs[0].radius", "gravity", "drag"]
        assert refused.json()["field"] == "pegs[0].radius"
    wedged = [{"x": x, "y": 2.0, "radius": 0.2} for x in (-1.25, -0.8, 0.8, 1.25)]
    refused = http.post("/api/v1/boards", json={**TINY, "ball": {"radius": 0.1}, "pegs": wedged})
    fields = [fault["field"] for fault in refused.json()["faults"]]
    # Two pegs together, and each with a side.
    assert fields == ["pegs[0]", "pegs[2]", "pegs[0]", "pegs[3]"]
    alone = http.post("/api/v1/boards", json={"gravity": -1.0})
    assert "faults" not in alone.json()


def test_the_list_of_boards_is_fetched_again_only_when_it_has_changed(http: httpx.Client) -> None:
    first = http.get("/api/v1/boards")
    etag = first.headers["etag"]
    again = http.get("/api/v1/boards", headers={"if-none-match": etag})
    assert (again.status_code, again.content, again.headers["etag"]) == (304, b"", etag)
    http.post("/api/v1/boards", json={**TINY, "name": "a board for the list"})
    changed = http.get("/api/v1/boards", headers={"if-none-match": etag})
    assert changed.status_code == 200
    assert "a board for the list" in {each["name"] for each in changed.json()["boards"]}
