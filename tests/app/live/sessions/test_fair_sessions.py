"""Fair sessions over REST and WebSocket, with several balls and many players."""

import asyncio
import copy
import hashlib
from typing import Any

import httpx
import pytest

from plinko.app.fairness.check import Verdict, check_session, kernel_digest_of
from plinko.app.fairness.export import read_export
from plinko.app.fairness.signing import is_signed
from plinko.app.settings import page_kernels
from plinko.engine.merkle import is_consistent
from tests.app.conftest import QUICK
from tests.kit.player import Player, playing
from tests.kit.serving import Running
from tests.kit.waiting import until

SEED = b"\x2a" * 32
COMMITMENT = hashlib.sha256(SEED).hexdigest()
KERNEL = kernel_digest_of(page_kernels().read_bytes())


def bearer(token: str) -> dict[str, str]:
    return {"authorization": f"Bearer {token}"}


def begun(http: httpx.Client, room: str = "main") -> tuple[dict[str, Any], dict[str, str]]:
    """Begin and open a session; returns it, and the header with its token."""
    answer = http.post("/api/v1/sessions", json={"room": room, "commitment": COMMITMENT})
    assert answer.status_code == 201, answer.text
    session = answer.json()
    shown = bearer(session["token"])
    opening = f"/api/v1/sessions/{session['session']}/opening"
    assert http.post(opening, json={"seed": SEED.hex()}, headers=shown).json()["open"]
    return session, shown


async def begun_by(player: Player) -> tuple[str, str]:
    """Begin and open a session in a player's room; returns it, and its token."""
    await player.send(type="session", commitment=COMMITMENT)
    state = await player.until("session")
    await player.send(type="open", session=state["session"], seed=SEED.hex())
    await player.until("session", open=True)
    return state["session"], state["token"]


def exported(http: httpx.Client, session: str, shown: dict[str, str]) -> dict[str, Any]:
    answer = http.get(f"/api/v1/sessions/{session}/export", headers=shown)
    assert answer.status_code == 200, answer.text
    found: dict[str, Any] = answer.json()
    return found


def checked(http: httpx.Client, session: str, shown: dict[str, str], **more: Any) -> Verdict:
    export = exported(http, session, shown)
    key = http.get("/api/v1/log").json()["key"]
    return check_session(read_export({**export, **more}), kernel_digest=KERNEL, key=key)


def drops_of(http: httpx.Client, session: str, shown: dict[str, str]) -> list[dict[str, Any]]:
    drops: list[dict[str, Any]] = exported(http, session, shown)["drops"]
    return drops


@pytest.fixture(scope="module")
def tiny(http: httpx.Client) -> str:
    room: str = http.post("/api/v1/rooms", json={"board": QUICK}).json()["id"]
    return room


def test_a_session_over_rest_is_proven_from_its_export(http: httpx.Client, tiny: str) -> None:
    session, shown = begun(http, tiny)
    drops = f"/api/v1/rooms/{tiny}/drops"
    heard = []
    for number in range(3):
        body = {"stake": 100, "session": session["session"]}
        answer = http.post(drops, params={"wait": 1}, json=body, headers=shown).json()
        assert (answer["receipt"]["receipt"]["drop"], "practice" in answer) == (number, False)
        assert answer["landed"]["payout"] in (100, 200)
        heard.append(answer["receipt"])
    before = checked(http, session["session"], shown)
    assert {step.name for step in before.failed} == {"server-seed-open", "end"}
    end = f"/api/v1/sessions/{session['session']}/end"
    ended = http.post(end, headers=shown).json()
    committed = hashlib.sha256(bytes.fromhex(ended["server_seed"])).hexdigest()
    assert committed == session["statement"]["server_commitment"]
    assert http.post(end, headers=shown).json() == ended
    verdict = checked(http, session["session"], shown, heard=heard)
    assert (verdict.failed, verdict.drops) == ([], 3)
    over = http.post(drops, json={"session": session["session"]}, headers=shown)
    assert (over.status_code, over.json()["code"]) == (409, "session-state")


def test_no_stake_with_a_chosen_start(http: httpx.Client, tiny: str) -> None:
    session, shown = begun(http, tiny)
    own = session["session"]
    before = http.get(f"/api/v1/rooms/{tiny}").json()["stats"]["drops"]
    wrong: list[tuple[dict[str, Any], str]] = [
        ({"stake": 1}, "invalid-value"),
        ({"stake": 1, "seed": "3173"}, "invalid-value"),
        ({"stake": 1, "x": 0.0}, "invalid-value"),
        ({"session": own, "seed": "3173"}, "invalid-value"),
        ({"session": own, "x": 0.0}, "invalid-value"),
        ({"session": "none", "stake": 1}, "not-yours"),
    ]
    for body, code in wrong:
        answer = http.post(f"/api/v1/rooms/{tiny}/drops", json=body, headers=shown)
        assert 400 <= answer.status_code < 500
        assert answer.json()["code"] == code
    assert http.get(f"/api/v1/rooms/{tiny}").json()["stats"]["drops"] == before


def test_a_chosen_start_is_practice_in_every_reply_and_log(http: httpx.Client, tiny: str) -> None:
    drops = f"/api/v1/rooms/{tiny}/drops"
    told = [
        http.post(drops, params={"wait": 1}, json=body).json()
        for body in ({"seed": "5"}, {"x": 0.1}, {})
    ]
    assert [each.get("practice", False) for each in told] == [True, True, False]
    assert [each["landed"].get("practice", False) for each in told] == [True, True, False]
    log = http.get(f"/api/v1/rooms/{tiny}/log").json()["drops"]
    by_ball = {each["ball"]: each.get("practice", False) for each in log}
    assert [by_ball[each["ball"]] for each in told] == [True, True, False]


def test_secrets_and_tokens_are_asked_for(http: httpx.Client, tiny: str) -> None:
    body = {"room": tiny, "commitment": COMMITMENT}
    session = http.post("/api/v1/sessions", json=body).json()
    address = f"/api/v1/sessions/{session['session']}"
    shown = bearer(session["token"])
    drop = {"stake": 1, "session": session["session"]}
    closed = http.post(f"/api/v1/rooms/{tiny}/drops", json=drop, headers=shown)
    assert (closed.status_code, closed.json()["code"]) == (409, "session-state")
    wrong = http.post(f"{address}/opening", json={"seed": "00" * 32}, headers=shown)
    assert "the seed does not match the commitment" in wrong.json()["detail"]
    assert http.post(f"{address}/end").status_code == 401
    assert http.post(f"{address}/end", headers=bearer("x")).status_code == 403
    # A session of another table drops nothing.
    assert http.post(f"{address}/opening", json={"seed": SEED.hex()}, headers=shown).is_success
    other = http.post("/api/v1/rooms/triangle-8/drops", json=drop, headers=shown)
    assert (other.status_code, other.json()["code"]) == (409, "session-state")
    assert checked(http, session["session"], shown).drops == 0


async def test_many_players_and_many_balls_in_one_room(
    server: Running, http: httpx.Client, tiny: str
) -> None:
    async with playing(server.socket(tiny)) as ada, playing(server.socket(tiny)) as ben:
        players = [(each, *await begun_by(each)) for each in (ada, ben)]
        for number in range(4):
            for player, session, _ in players:
                await player.send(type="drop", session=session, stake=100, ref=number)
        heard: dict[str, list[dict[str, Any]]] = {}
        for player, session, _ in players:
            for number in range(4):
                accepted = await player.until("accepted", ref=number)
                heard.setdefault(session, []).append(accepted["receipt"])
                assert accepted["receipt"]["receipt"]["drop"] == number
        # The log is public: both clients received the same receipts.
        for balls in heard.values():
            for receipt in balls:
                ball = receipt["receipt"]["ball"]
                for player in (ada, ben):
                    if not any(each.get("ball") == ball and each["type"] == "landed"
                               for each in player.events):  # fmt: skip
                        await player.until("landed", ball=ball)
        for player, session, token in players:
            await player.send(type="end", session=session, ref="over")
            await player.until("ended", ref="over")
            verdict = checked(http, session, bearer(token), heard=heard[session])
            assert (verdict.failed, verdict.drops) == ([], 4)


async def test_a_session_that_broke_off_goes_on_where_it_was(
    server: Running, http: httpx.Client, tiny: str
) -> None:
    async with playing(server.socket(tiny)) as player:
        session, token = await begun_by(player)
        await player.send(type="drop", session=session, stake=50, ref=3)
        await player.until("accepted", ref=3)
    async with playing(server.socket(tiny)) as player:
        await player.send(type="drop", session=session, stake=50, ref=4)
        assert (await player.until("error", ref=4))["code"] == "unknown-session"
        await player.send(type="session", session=session, token="no", ref=5)
        assert (await player.until("error", ref=5))["code"] == "not-yours"
        await player.send(type="session", session=session, token=token, ref=6)
        state = await player.until("session", ref=6)
        assert (state["drops"], state["open"], state["token"]) == (1, True, None)
        await player.send(type="drop", session=session, stake=50, ref=7)
        ball = (await player.until("accepted", ref=7))["ball"]
        await player.until("landed", ball=ball)
        await player.send(type="end", session=session, ref=8)
        await player.until("ended", ref=8)
    until(lambda: all(drop["result"] for drop in drops_of(http, session, bearer(token))))
    verdict = checked(http, session, bearer(token))
    assert (verdict.failed, verdict.drops) == ([], 2)


async def test_what_a_socket_says_of_a_session_is_done_in_its_order(
    server: Running, http: httpx.Client, tiny: str
) -> None:
    """The client waits for no answer: a drop follows the opening, and the end follows the drops."""
    async with playing(server.socket(tiny)) as player:
        await player.send(type="session", commitment=COMMITMENT, ref="begin")
        state = await player.until("session", ref="begin")
        session, token = state["session"], state["token"]
    async with playing(server.socket(tiny)) as player:
        await player.send(type="session", session=session, token=token, ref="join")
        await player.send(type="open", session=session, seed=SEED.hex(), ref="open")
        for number in range(3):
            await player.send(type="drop", session=session, stake=50, ref=number)
        await player.send(type="end", session=session, ref="end")
        await player.send(type="drop", session=session, stake=50, ref="late")
        assert (await player.until("error"))["ref"] == "late"
        told = [
            (each["type"], each["ref"]) for each in player.events if each.get("ref") is not None
        ]
        drops = [("accepted", number) for number in range(3)]
        joined = [("session", "join"), ("session", "open")]
        assert told == [*joined, *drops, ("ended", "end"), ("error", "late")]
    assert checked(http, session, bearer(token)).drops == 3


async def test_only_its_player_can_export_a_session_and_simultaneous_ends_get_one_answer(
    server: Running, http: httpx.Client, tiny: str
) -> None:
    session, shown = begun(http, tiny)
    # Every client in the room receives the session's id with each receipt.
    path = f"/api/v1/sessions/{session['session']}/export"
    _, other = begun(http, tiny)
    for headers, refusal in (({}, (401, "token-missing")), (other, (403, "not-yours"))):
        answer = http.get(path, headers=headers)
        assert (answer.status_code, answer.json()["code"]) == refusal
    assert exported(http, session["session"], shown)["session"]["statement"] == session["statement"]
    path = f"/api/v1/sessions/{session['session']}/end"
    async with httpx.AsyncClient(base_url=server.url, timeout=60.0, headers=shown) as client:
        answers = await asyncio.gather(*(client.post(path) for _ in range(10)))
    assert [answer.status_code for answer in answers] == [200] * 10
    assert len({answer.content for answer in answers}) == 1


def test_an_export_says_nothing_of_a_drop_that_is_not_checked(
    http: httpx.Client, tiny: str
) -> None:
    session, shown = begun(http, tiny)
    body = {"stake": 1, "session": session["session"]}
    http.post(f"/api/v1/rooms/{tiny}/drops?wait=1", json=body, headers=shown)
    http.post(f"/api/v1/sessions/{session['session']}/end", headers=shown)
    until(lambda: drops_of(http, session["session"], shown)[0]["result"])
    told = exported(http, session["session"], shown)
    for name, value in told["drops"][0]["result"].items():
        other = copy.deepcopy(told)
        other["drops"][0]["result"][name] = "else" if isinstance(value, str | None) else value + 1
        verdict = check_session(read_export(other), kernel_digest=KERNEL)
        assert not verdict.ok, name


def test_the_log_says_that_it_only_grew(http: httpx.Client, tiny: str) -> None:
    session, shown = begun(http, tiny)
    heads = []
    for _ in range(2):
        body = {"stake": 1, "session": session["session"]}
        http.post(f"/api/v1/rooms/{tiny}/drops", json=body, headers=shown)
        heads.append(http.get("/api/v1/log").json()["head"]["statement"])
    told = http.get("/api/v1/log", params={"since": heads[0]["size"]}).json()
    head = told["head"]["statement"]
    assert is_signed(head, bytes.fromhex(told["head"]["signature"]), bytes.fromhex(told["key"]))
    proof = [bytes.fromhex(node) for node in told["consistency"]]
    before, after = (bytes.fromhex(each["root"]) for each in (heads[0], head))
    assert is_consistent(heads[0]["size"], head["size"], before, after, proof)
    assert http.get("/api/v1/log", params={"since": 10**9}).status_code == 422
