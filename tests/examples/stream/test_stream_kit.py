"""The stream kit: what viewers do becomes balls by its rules, once, whatever breaks meanwhile."""

import asyncio
import base64
import importlib.util
import json
import re
import signal
import sys
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
from aiohttp import web

from tests.examples.stream.fake_obs import PASSWORD, FakeObs, fake_obs
from tests.examples.stream.fake_twitch import PICTURE, FakeTwitch, fake_twitch
from tests.examples.stream.kit import STREAM, Kit, running
from tests.kit.process import ServerProcess
from tests.kit.serving import Running, serving
from tests.kit.waiting import LIMIT, eventually

# The fakes cut connections off, as a killed program does, and close nothing.
pytestmark = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")

RULES = """
[timer]
start = 100
label = "Ends in"
[jackpot]
start = 5
unit = "x"
[goals.Balls]
target = 4
reached = { say = "Four balls!" }
[in."!drop"]
every = 3600
[in.bits]
per = 100
[in.sub]
balls = 5
[in.gift]
balls = 2
[in."points:A ball"]
[in.donation]
per = 2.5
[in."!start"]
mods = true
balls = 0
pause = false
"""
COUNTED = """
[[landing]]
timer = 60
jackpot = 0.5
goals = { Balls = 1 }
"""


@pytest.fixture(scope="module")
def server() -> Iterator[Running]:
    with serving(drop_rate=1000) as running_server:
        yield running_server


@pytest.fixture
async def twitch() -> AsyncIterator[FakeTwitch]:
    async with fake_twitch() as one:
        yield one


@pytest.fixture
async def obs() -> AsyncIterator[FakeObs]:
    async with fake_obs() as one:
        yield one


async def still(kit: Kit, balls: dict[str, int]) -> None:
    """Wait until these balls have landed; no other ball may wait then."""
    await eventually(lambda: kit.balls() == balls)
    assert kit.waiting == 0


def dropped(server_url: str, room: str) -> dict[str, int]:
    """The balls of each viewer in the server's ledger."""
    log = httpx.get(f"{server_url}/api/v1/rooms/{room}/log", timeout=LIMIT).json()
    names = [drop.get("name", "") for drop in log["drops"]]
    return {name: names.count(name) for name in names}


async def show_of(server_url: str, room: str) -> dict[str, Any]:
    async with httpx.AsyncClient(timeout=LIMIT) as http:
        view = (await http.get(f"{server_url}/api/v1/rooms/{room}/show")).json()
    found: dict[str, Any] = view["show"]
    return found


async def test_events_of_twitch_become_balls_by_the_rules(
    server: Running, twitch: FakeTwitch, tmp_path: Path
) -> None:
    async with running(tmp_path, server.url, RULES + twitch.rules) as kit:
        assert "activate and enter the code ABCDEFGH" in await kit.prints("enter the code")
        viewer = {"user_id": "7", "user_name": "Ada"}
        await twitch.chat("Ben", "!Drop \U0001f9c0")
        await twitch.chat("Ben", "!drop again, too early")
        await twitch.chat("Cleo", "please !drop")
        await twitch.chat("Cleo", "!other")
        await twitch.chat("Cleo", "sub")
        await twitch.chat("Dora", "!drop", number="twice")
        await twitch.chat("Dora", "!drop", number="twice")
        await twitch.send("channel.cheer", bits=150, is_anonymous=False, **viewer)
        await twitch.send("channel.cheer", bits=260, is_anonymous=False, **viewer)
        await twitch.send(
            "channel.cheer", bits=100, is_anonymous=True, user_id=None, user_name=None
        )
        await twitch.send(
            "channel.subscribe", tier="1000", is_gift=False, user_id="8", user_name="Eva"
        )
        await twitch.send(
            "channel.subscribe", tier="1000", is_gift=True, user_id="9", user_name="Fay"
        )
        await twitch.send(
            "channel.subscription.message", cumulative_months=3, user_id="8", user_name="Eva"
        )
        await twitch.send("channel.subscription.gift", total=3, user_id="10", user_name="Gus")
        reward = {"id": "r", "title": "A ball", "cost": 500, "prompt": ""}
        points = "channel.channel_points_custom_reward_redemption.add"
        await twitch.send(points, reward=reward, user_input="", user_id="11", user_name="Hal")
        await twitch.send(points, reward={**reward, "title": "Hydrate"}, user_input="", **viewer)
        expected = {"Ben": 1, "Dora": 1, "Ada": 4, "Anonymous": 1, "Eva": 10, "Gus": 6, "Hal": 1}
        await still(kit, expected)
        assert dropped(server.url, kit.room) == expected

        def answers() -> dict[str, list[str]]:
            told = " · ".join(twitch.said)
            return {name: re.findall(rf"@{name} ([^·]+)", told) for name in expected}

        await eventually(lambda: all(answers().values()))
        assert re.fullmatch(r"[12]x \(bin [01]\)", answers()["Ben"][0].strip())
        assert re.fullmatch(r"6 balls: \d+x, the best [12]x", answers()["Gus"][0].strip())


async def test_the_stage_shows_timer_goal_jackpot_and_faces(
    server: Running, twitch: FakeTwitch, tmp_path: Path
) -> None:
    rules = RULES + COUNTED + twitch.rules + '[looks]\nlogo = "logo.svg"\naccent = "#a78bfa"\n'
    (tmp_path / "logo.svg").write_text("<svg/>")
    # Balls that fall for a while: a face is shown only until its ball has landed.
    async with running(tmp_path, server.url, rules, 'texts = "."') as kit:
        first = await show_of(server.url, kit.room)
        await eventually((tmp_path / "timer.txt").exists)
        await twitch.chat("Ada", "!start", "moderator")
        await twitch.chat("Ben", "!start")
        for name in ("Ada", "Ben", "Cleo", "Dora"):
            await twitch.chat(name, "!drop" if name != "Ben" else "!drop \U0001f9c0")
        await still(kit, dict.fromkeys(("Ada", "Ben", "Cleo", "Dora"), 1))
        faces = dict(kit.rows("SELECT user, face FROM faces"))
        assert faces["twitch:id of Ben"] == "\U0001f9c0"
        avatar = base64.b64encode(PICTURE).decode()
        assert faces["twitch:id of Ada"] == f"data:image/png;base64,{avatar}"
        async with asyncio.timeout(LIMIT):
            while (show := await show_of(server.url, kit.room)).get("jackpot", {}).get(
                "value"
            ) != 7.0:
                await asyncio.sleep(0.1)
        assert show["goals"] == [{"value": 4.0, "target": 4.0, "label": "Balls"}]
        assert show["looks"]["accent"] == "#a78bfa"
        assert show["looks"]["logo"].startswith("data:image/svg+xml;base64,")
        assert show["timer"]["running"]
        assert 300 < show["timer"]["left"] <= 340
        await eventually(lambda: any("Four balls!" in line for line in twitch.said))
        await eventually(lambda: (tmp_path / "goal Balls.txt").read_text() == "4 / 4")
        assert (tmp_path / "jackpot.txt").read_text() == "7"
        assert first.get("timer", {"running": False})["running"] is False


async def test_a_bin_drops_again_and_pays_the_jackpot_once(
    server: Running, twitch: FakeTwitch, tmp_path: Path
) -> None:
    rules = '[in."!drop"]\nballs = 20\n[jackpot]\nstart = 3\n' + twitch.rules + """
[[landing]]
bin = [0]
again = 1
[[landing]]
least = 2
jackpot = 1
[[landing]]
bin = [0]
pay = true
say = "{name} wins {jackpot}"
"""  # fmt: skip
    async with running(tmp_path, server.url, rules) as kit:
        await twitch.chat("Ada", "!drop")
        await eventually(lambda: kit.balls().get("Ada", 0) >= 20 and not kit.waiting)
        bins = [row[0] for row in kit.rows("SELECT bin FROM balls ORDER BY landed, number")]
        assert bins.count(1) == 20, "each ball of bin 0 has another one after it"
        assert dropped(server.url, kit.room) == {"Ada": len(bins)}
        await eventually(lambda: " ".join(twitch.said).count("Ada wins") == bins.count(0))
        paid = [float(each) for each in re.findall(r"Ada wins (\d+)", " ".join(twitch.said))]
        assert sum(paid) + kit.state("show")["jackpot"] == 3 * (bins.count(0) + 1) + 20


async def test_a_kit_goes_on_at_another_connection_and_with_a_new_token(
    server: Running, twitch: FakeTwitch, tmp_path: Path
) -> None:
    async with running(tmp_path, server.url, RULES + twitch.rules) as kit:
        await twitch.chat("Ada", "!drop")
        await still(kit, {"Ada": 1})
        await twitch.move()
        await twitch.chat("Ben", "!drop")
        await still(kit, {"Ada": 1, "Ben": 1})
        assert twitch.signed_in == 1
        twitch.tokens.append("token that the kit does not know")
        twitch.tokens.pop()
        await kit.end()
        twitch.tokens[-1] = "expired"  # only its refresh token is valid now
        await kit.start()
        await twitch.chat("Cleo", "!drop")
        await still(kit, {"Ada": 1, "Ben": 1, "Cleo": 1})
        assert twitch.signed_in == 1, "no code had to be entered again"


async def test_a_token_that_cannot_be_renewed_at_first_stops_no_answer(
    server: Running, twitch: FakeTwitch, tmp_path: Path
) -> None:
    async with running(tmp_path, server.url, RULES + twitch.rules) as kit:
        await eventually(lambda: twitch.subscribed)
        twitch.tokens[-1] = "expired"
        twitch.broken_renewals = 2
        await twitch.chat("Ada", "!drop")
        await eventually(lambda: any("@Ada" in line for line in twitch.said))
        assert twitch.broken_renewals == 0
        assert twitch.signed_in == 1, "no code had to be entered again"
        for line in (*kit.lines, kit.log):
            assert not re.search("refresh 1|token 1|secret", line), "no secret is logged"


async def test_a_connection_that_moves_keeps_its_subscriptions_although_the_former_stays_open(
    server: Running, twitch: FakeTwitch, tmp_path: Path
) -> None:
    twitch.closes_former = False
    async with running(tmp_path, server.url, RULES + twitch.rules) as kit:
        await eventually(lambda: len(twitch.subscribed) == 6)
        await twitch.move()
        await twitch.chat("Ada", "!drop")
        await still(kit, {"Ada": 1})
        await eventually(lambda: twitch.connections == 1)  # the kit leaves what has fallen silent
        await twitch.chat("Ben", "!drop")
        await still(kit, {"Ada": 1, "Ben": 1})
        assert twitch.subscriptions == 6, "a second set would send each event twice"
        assert kit.log == ""


async def test_kit_platform_and_server_may_break(twitch: FakeTwitch, tmp_path: Path) -> None:
    ledger = f"sqlite:///{tmp_path / 'plinko.db'}"
    names = [f"viewer {n}" for n in range(12)]
    with ServerProcess(ledger=ledger, flags=("--data", str(tmp_path))) as game:
        async with running(tmp_path, game.url, RULES + twitch.rules) as kit:
            for number, name in enumerate(names):
                await twitch.chat(name, "!drop")
                if number == 3:
                    await kit.end()
                if number == 5:
                    await kit.start()
                if number == 6:
                    await twitch.kill()
                    await twitch.start()
                if number == 9:
                    await asyncio.to_thread(game.end, signal.SIGKILL)
                if number == 10:
                    await asyncio.to_thread(game.start)
            await still(kit, dict.fromkeys(names, 1))
            assert dropped(game.url, kit.room) == dict.fromkeys(names, 1)
            room = kit.room
            own = {"authorization": f"Bearer {kit.state('token')}"}
            await kit.end()
            httpx.delete(f"{game.url}/api/v1/rooms/{room}", headers=own, timeout=LIMIT)
            await kit.start()
            await eventually(lambda: kit.room != room)
            await twitch.chat("late", "!drop")
            await still(kit, {**dict.fromkeys(names, 1), "late": 1})
            assert dropped(game.url, kit.room) == {"late": 1}


async def test_a_busy_game_behind_a_broken_proxy_is_asked_again_for_the_same_ball(
    tmp_path: Path,
) -> None:
    landed = {"type": "landed", "bin": 1, "score": 2.0}
    replies: list[tuple[int, str]] = [
        (502, "<html>proxy</html>"), (200, "<html>proxy</html>"), (200, "[]"), (200, "{}"),
        (429, '{"detail": "slowly"}'), (500, "{}"), (503, '{"detail": "full"}'), (202, "{}"),
        (200, json.dumps({"landed": landed})),
    ]  # fmt: skip
    keys: list[tuple[str | None, str | None]] = []

    async def drop(request: web.Request) -> web.Response:
        keys.append((request.headers.get("Idempotency-Key"), request.headers["Idempotency-Secret"]))
        status, text = replies.pop(0)
        return web.Response(status=status, text=text, headers={"Retry-After": "0"})

    async def other(_: web.Request) -> web.Response:
        return web.json_response({"id": "r", "token": "t"}, status=201)

    application = web.Application()
    rooms = "/api/v1/rooms"
    application.add_routes([
        web.post(rooms, other), web.put(f"{rooms}/r/show", other),
        web.post(f"{rooms}/r/drops", drop),
    ])  # fmt: skip
    runner = web.AppRunner(application, access_log=None)
    await runner.setup()
    await web.TCPSite(runner, "127.0.0.1", 0).start()
    async with running(tmp_path, f"http://127.0.0.1:{runner.addresses[0][1]}", "[in.sub]") as kit:
        async with httpx.AsyncClient(timeout=LIMIT) as http:
            await http.get(kit.address, params={"kind": "sub", "name": "Ada"})
        await still(kit, {"Ada": 1})
    await runner.cleanup()
    assert len(keys) == 9
    assert len(set(keys)) == 1


async def test_obs_shows_scenes_sources_and_the_stage(
    server: Running, obs: FakeObs, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OBS_PASSWORD", PASSWORD)
    rules = '[in.gift]\nscene = "Jackpot"\nsource = "Confetti"\nsound = "win.ogg"\nseconds = 0.2\n'
    async with running(tmp_path, server.url, rules + obs.rules) as kit:
        await eventually(lambda: obs.inputs["Plinko"].get("url", "").endswith(f"room={kit.room}"))
        async with httpx.AsyncClient(timeout=LIMIT) as http:
            await http.get(kit.address, params={"kind": "gift", "name": "Ada"})
        await eventually(
            lambda: obs.scenes[-1:] == ["Game"] and obs.shown[-1:] == [("Confetti", False)]
        )
        assert obs.scenes == ["Jackpot", "Game"]
        assert obs.shown == [("Confetti", True), ("Confetti", False)]
        assert obs.played == [str(tmp_path / "sounds" / "win.ogg")]


async def test_after_scenes_that_overlap_obs_shows_the_streamers_own(
    server: Running, obs: FakeObs, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OBS_PASSWORD", PASSWORD)
    rules = """
[in.gift]
scene = "Jackpot"
seconds = 2
[in.sub]
scene = "Party"
seconds = 2
say = "from {name}{bin}"
"""
    async with (
        running(tmp_path, server.url, rules + obs.rules) as kit,
        httpx.AsyncClient(timeout=LIMIT) as http,
    ):
        await eventually(lambda: "url" in obs.inputs["Plinko"])
        await http.get(kit.address, params={"kind": "gift", "name": "Ada"})
        await eventually(lambda: obs.scenes == ["Jackpot"])
        await http.get(kit.address, params={"kind": "sub", "name": "Ben"})
        await eventually(lambda: obs.scenes == ["Jackpot", "Party", "Game"])


async def test_a_wrong_password_of_obs_stops_no_ball(
    server: Running, obs: FakeObs, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OBS_PASSWORD", "wrong")
    async with running(tmp_path, server.url, '[in.gift]\nscene = "Jackpot"\n' + obs.rules) as kit:
        await eventually(lambda: obs.refused)
        async with httpx.AsyncClient(timeout=LIMIT) as http:
            await http.get(kit.address, params={"kind": "gift", "name": "Ada"})
        await still(kit, {"Ada": 1})
        await eventually(lambda: "is the password right?" in kit.log)


async def test_other_programs_send_events_to_one_address(server: Running, tmp_path: Path) -> None:
    async with (
        running(tmp_path, server.url, RULES) as kit,
        httpx.AsyncClient(timeout=LIMIT) as http,
    ):
        query = {"kind": "donation", "name": "Ada", "amount": "6", "id": "d-1"}
        for _ in range(2):
            assert (await http.get(kit.address, params=query)).json() == {"balls": 2}
        more = {"kind": "donation", "name": "Ada", "amount": 1.5, "id": "d-2", "wait": 1}
        told = await http.post(kit.address, json=more)
        assert re.fullmatch(r"@Ada [12]x \(bin [01]\)", told.text), "1 and 1.5 are another ball"
        assert (await http.get(kit.address, params={"kind": "raid"})).json() == {"balls": 0}
        for wrong in ({"kind": "sub", "amount": "many"}, {"kind": "sub", "amount": "nan"}, {},
                      {"kind": "sub", "face": "<b>"},
                      {"kind": "sub", "colour": "red"}):  # fmt: skip
            refused = await http.get(kit.address, params=wrong)
            assert refused.status_code == 422, refused.text
        for body in ("[1]", '"sub"', "{", "null"):
            refused = await http.post(kit.address, content=body)
            assert refused.status_code == 422, refused.text
        assert "Expected `object`" in refused.text
        foreign = re.sub(r"/\w+/event", "/guess/event", kit.address)
        assert (await http.get(foreign, params=query)).status_code == 404
        strange = {"kind": "sub", "name": "<b>\u202eEve\n  of a very long name, indeed</b>"}
        await http.post(kit.address, json=strange)
        await eventually(lambda: not kit.waiting)
        assert dropped(server.url, kit.room) == {"Ada": 3, "bEve of a very long name, ": 5} or (
            "bEve of a very long name," in dropped(server.url, kit.room)
        )


@pytest.fixture
def kit_module() -> Iterator[Any]:
    """kit.py itself, as a module; tests.examples.stream.kit runs it."""
    spec = importlib.util.spec_from_file_location("stream_kit", STREAM / "kit.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["stream_kit"] = module  # where msgspec looks for the types of annotations
    try:
        spec.loader.exec_module(module)
        yield module
    finally:
        del sys.modules["stream_kit"]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[game]\nserver = 'x'\n\n[in.bits]\nper = 'a'\n", "line 5, per = 'a': Expected `float"),
        (
            "[[landing]]\ntimer = 3\n[[landing]]\nmin = 3\n",
            "line 4, min = 3: .*unknown field `min`",
        ),
        ("[in.bits]\nballs = 3\n", r"line 1, \[in.bits\]: .* needs `per`"),
        ("[in.sub]\nballs = 1\ngoals = {Bals = 1}\n", 'line 3, .*no goal has the name "Bals"'),
        ("[goals.A]\ntarget = 1\n[goals.B]\n", r"line 3, \[goals.B\]: .*missing .*`target`"),
        ("[in.sub]\nsay = '{who}'\n", "line 2, say = '{who}'"),
        ("[goals.A]\ntarget = 1\n[goals.A.reached]\nsay = '{who}'\n", "line 4, say = '{who}'"),
        ("[goals.A]\ntarget = 1\nreached = {goals = {B = 1}}\n", 'line 3, .*has the name "B"'),
        ("[in.sub]\nballs = -1\n", "line 2, balls = -1"),
        ("[[landing]]\nbin = [\n  1,\n  'x',\n]\n", r"line 5, \]: .*bin"),
        ("[twitch]\nclient_id =\n[obs]\n", "line 2"),
    ],
)
def test_a_mistake_in_the_rules_is_named_with_its_line(
    kit_module: Any, tmp_path: Path, text: str, told: str
) -> None:
    file = tmp_path / "rules.toml"
    file.write_text(text)
    with pytest.raises(SystemExit, match=told):
        kit_module.read_rules(file)


def test_the_rules_that_come_with_the_kit_are_right(kit_module: Any, tmp_path: Path) -> None:
    text = (STREAM / "rules.toml").read_text()
    whole = re.sub(r"(?m)^# (\[|\w+ =)", r"\1", text)  # with the parts that are left out
    assert whole.count("\n") == text.count("\n")
    file = tmp_path / "rules.toml"
    file.write_text(whole)
    assert kit_module.read_rules(file).twitch is not None
