"""The stage page: what an audience sees, in frames of every size, on every backdrop."""

import json
import re
import signal
from functools import partial
from typing import Any

import httpx
from playwright.sync_api import ViewportSize, expect

from plinko.engine import Board
from tests.app.web.test_invitations import read
from tests.browser.access.axe import check_axe
from tests.browser.conftest import Complaints, Open, quick_table
from tests.browser.screen import Screen
from tests.browser.table.test_reconnect import GONE
from tests.kit.address import Address
from tests.kit.process import ServerProcess
from tests.kit.waiting import LIMIT, until

FRAMES: list[ViewportSize] = [
    {"width": 1920, "height": 1080},
    {"width": 1080, "height": 1920},
    {"width": 1080, "height": 1350},
    {"width": 640, "height": 360},
]

# A right-to-left name with an emoji, which must not move the page's own text.
NAME = "\u05e9\u05e8\u05d4 \U0001f388"
_NAMED = f"localStorage.setItem('plinko.visitor.1', {json.dumps(json.dumps({'name': NAME}))})"

_TO_CLICK = "document.querySelectorAll('a, button, input, select, textarea, [tabindex]').length"

# How far each side of an element exceeds the window, px, and the board's share of the stage.
_LAID_OUT = """
() => {
  const box = (id) => document.getElementById(id).getBoundingClientRect();
  const parts = ["board", "winners-panel", "leaders-panel", "queue-panel",
    "join-panel", "tray"];
  const beyond = parts.map(box).map((one) => Math.max(
    -one.left, -one.top, one.right - innerWidth, one.bottom - innerHeight));
  const [board, stage] = [box("board"), document.querySelector(".stage").getBoundingClientRect()];
  const fills = Math.max(board.width / stage.width, board.height / stage.height);
  const lesson = box("tray").height / innerHeight;
  return { lesson, beyond: Math.max(...beyond), fills, part: board.width * board.height
    / (innerWidth * innerHeight) };
}
"""

# The parts of the page that the show's panel covers, or that are outside of the window.
_APART = """
() => {
  const box = (id) => document.getElementById(id).getBoundingClientRect();
  const show = box("figures");
  const others = ["winners-panel", "leaders-panel", "queue-panel", "join-panel"].filter((id) => {
    const one = box(id);
    const beside = one.left >= show.right || one.right <= show.left;
    return !beside && one.top < show.bottom && one.bottom > show.top;
  });
  const inside = show.left >= 0 && show.right <= innerWidth && show.bottom <= innerHeight;
  return inside ? others : [...others, "figures"];
}
"""

# For each colour, how many bright pixels below the board have its hue, as a ball's bright side has.
_PAINTED = """
(colours) => {
  const canvas = document.getElementById("histogram");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const bytes = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
  const wanted = colours.map(bytes);
  const counts = colours.map(() => 0);
  for (let at = 0; at < data.length; at += 4) {
    const pixel = data.subarray(at, at + 3);
    if (Math.max(...pixel) < 140) continue;
    wanted.forEach((colour, i) => {
      const along = colour.reduce((sum, part, channel) => sum + part * pixel[channel], 0);
      if (along > 0.98 * Math.hypot(...colour) * Math.hypot(...pixel)) counts[i] += 1;
    });
  }
  return counts;
}
"""

# The opacity of the still picture in a corner and between two pegs, and the colours below it.
_GROUNDS = """
() => {
  const canvas = document.getElementById("board-still");
  const ctx = canvas.getContext("2d");
  const alpha = (x, y) => ctx.getImageData(x * canvas.width, y * canvas.height, 1, 1).data[3];
  const below = ["html", "body", ".stage", ".board"]
    .map((name) => getComputedStyle(document.querySelector(name)).backgroundColor);
  return { around: alpha(0.02, 0.3), plate: alpha(0.5, 0.51), below: [...new Set(below)] };
}
"""


# Records text painted on offscreen canvases, such as names at balls.
_WRITTEN = """
const { prototype } = OffscreenCanvasRenderingContext2D;
const { fillText } = prototype;
window.written = new Set();
prototype.fillText = function (text, ...place) {
  window.written.add(text);
  return fillText.call(this, text, ...place);
};
"""


def written(screen: Screen) -> set[str]:
    return set(screen.page.evaluate("[...window.written]"))


def there(screen: Screen) -> Screen:
    return screen.state("asleep", "live")


def grounds(stage: Screen) -> dict[str, Any]:
    """What is below the board and around it, once the board is painted."""
    there(stage).frames(4)  # it is laid out in one frame and painted in the next
    found: dict[str, Any] = stage.page.evaluate(_GROUNDS)
    return found


def test_an_audience_sees_who_won_what_and_has_nothing_to_click(
    opened: Open, server: Address
) -> None:
    quick = quick_table(server, "triangle-8", prize="Mug")
    stage = there(opened(f"/stage.html?room={quick.room}&leaders=prizes&join=on"))
    player = opened(quick.page, before=_NAMED, viewport={"width": 390, "height": 844}).ready()
    winners, leaders = (stage.page.locator(f"#{name} > li") for name in ("winners", "leaders"))
    expect(winners).to_have_count(0)
    for _ in range(6):
        player.drop.click()
    expect(leaders).to_have_text(f"{NAME}6")
    expect(winners).to_have_count(5)
    expect(winners.first).to_have_text(f"{NAME}Mug")
    expect(winners.first.locator(".paid")).to_have_css("background-color", "rgb(192, 57, 43)")
    assert stage.page.evaluate(_TO_CLICK) == 0
    expect(stage.page.locator("#join")).to_have_js_property("complete", value=True)
    assert stage.page.locator("#join").evaluate("image => image.naturalWidth") > 0
    sent = {json.loads(frame)["type"] for frame in stage.sent}
    assert sent <= {"appear", "ping"}, "nothing is played"
    check_axe(stage)
    for size in FRAMES:
        stage.page.set_viewport_size(size)
        name = f"{size['width']}x{size['height']}"
        stage.frames(4)
        found = stage.page.evaluate(_LAID_OUT)
        assert found["beyond"] <= 0, name
        assert found["fills"] > 0.99, name
        assert found["part"] > 0.3, name
        stage.shot(f"stage-{name}")


def test_before_anybody_plays_the_board_has_the_frame_and_demo_balls_fall(
    opened: Open, server: Address
) -> None:
    quick = quick_table(server, "triangle-8")
    stage = there(opened(f"/stage.html?room={quick.room}"))
    for size in FRAMES:
        stage.page.set_viewport_size(size)
        stage.frames(4)
        board = stage.page.locator("#board").bounding_box()
        assert board
        middle = board["x"] + board["width"] / 2
        assert abs(middle - size["width"] / 2) <= 1, "in the middle"
        expect(stage.page.locator("#winners-panel")).to_be_hidden()
    expect(stage.page.locator("#demo-mark")).to_be_visible()
    player = opened(quick.page).ready()
    player.drop.click()
    expect(stage.page.locator("#winners > li")).to_have_count(1)
    expect(stage.page.locator("#winners-panel")).to_have_text(re.compile("Last balls"))
    expect(stage.page.locator("#demo-mark")).to_be_hidden()


def own_room(server: Address, name: str) -> tuple[str, dict[str, str]]:
    """Open a room with a board of this name; returns its id and the headers of its owner."""
    board = Board.preset("triangle-8").replace(name=name).to_dict()
    rooms = f"{server.url}/api/v1/rooms"
    room = httpx.post(rooms, json={"board": board}, timeout=LIMIT).raise_for_status().json()
    return room["id"], {"authorization": f"Bearer {room['token']}"}


def test_a_named_drop_shows_its_name_on_the_stage_and_the_table(
    opened: Open, server: Address
) -> None:
    # No quick table: a busy machine must not miss all frames in which the ball falls.
    room, own = own_room(server, "named")
    address = f"/stage.html?room={room}"
    stage = there(opened(address, before=_WRITTEN))
    silent = there(opened(f"{address}&names=off", before=_WRITTEN))
    player = opened(f"/?room={room}", before=_WRITTEN).ready()
    drop = {"name": NAME, "colour": "#e91e63"}
    drops = f"{server.url}/api/v1/rooms/{room}/drops"
    reply = httpx.post(drops, json=drop, headers=own, timeout=LIMIT)
    assert reply.status_code == 202, reply.text
    for screen, lists in ((stage, ("winners", "leaders")), (silent, ("winners", "leaders"))):
        for name in lists:
            row = screen.page.locator(f"#{name} > li")
            expect(row).to_contain_text(NAME)
            expect(row.locator(".swatch")).to_have_css("background-color", "rgb(233, 30, 99)")
    player.drawer("Game")
    expect(player.page.locator("#landings > li")).to_contain_text(NAME)
    assert NAME in written(stage) & written(player)
    assert NAME not in written(silent)


def test_a_show_has_its_timer_goals_jackpot_faces_and_looks(opened: Open, server: Address) -> None:
    room, own = own_room(server, "shown")
    stage = there(opened(f"/stage.html?room={room}&join=on", before=_WRITTEN))
    figures = stage.page.locator("#figures")
    expect(figures).to_be_hidden()
    show = {
        "timer": {"left": 7384, "label": "Ends in", "running": False},
        "jackpot": {"value": 12.5, "label": "Jackpot", "unit": "x"},
        "goals": [{"value": 3, "target": 4, "label": "Balls"}],
        "looks": {"panel": "#102030", "ink": "#ffffff", "accent": "#a78bfa"},
        "faces": {NAME: "\U0001f9c0"},
    }
    path = f"{server.url}/api/v1/rooms/{room}"
    httpx.put(f"{path}/show", json=show, headers=own, timeout=LIMIT).raise_for_status()
    expect(figures).to_be_visible()
    expect(stage.page.locator("#timer")).to_have_text("Ends in 2:03:04")
    expect(stage.page.locator("#jackpot")).to_have_text("Jackpot 12.5x")
    expect(stage.page.locator("#goals")).to_have_text("Balls3 / 4")
    expect(figures).to_have_css("color", "rgb(255, 255, 255)")
    assert "\U0001f9c0" in written(stage)
    body = {"name": NAME}
    httpx.post(f"{path}/drops", json=body, headers=own, timeout=LIMIT).raise_for_status()
    expect(stage.page.locator("#winners > li")).to_have_count(1)
    check_axe(stage)
    for size in (
        *FRAMES,
        ViewportSize(width=720, height=1280),
        ViewportSize(width=390, height=844),
    ):
        stage.page.set_viewport_size(size)
        stage.frames(4)
        apart = stage.page.evaluate(_APART)
        assert apart == [], f"{size}: the show covers {apart}"
    show["timer"] = {"left": 1}
    httpx.put(f"{path}/show", json=show, headers=own, timeout=LIMIT).raise_for_status()
    expect(stage.page.locator("#timer-value")).to_have_text("0:00")


def test_the_queue_is_shown_and_goes_on_after_a_kill(
    opened: Open, mortal: ServerProcess, complaints: Complaints
) -> None:
    complaints.allow(GONE)
    quick = quick_table(mortal, "triangle-8")
    stage = there(opened(f"{mortal.url}/stage.html?room={quick.room}&leaders=balls"))
    player = opened(f"{mortal.url}{quick.page}").ready()
    path = f"{mortal.url}/api/v1/rooms/{quick.room}"
    own = {"authorization": f"Bearer {quick.token}"}
    http = httpx.Client(headers=own, timeout=LIMIT)
    http.patch(f"{path}/queue", json={"paused": True}).raise_for_status()
    for name, n in ((NAME, 12), ("Ben", 900)):
        item = {"n": n, "name": name, "every": 0.1}
        http.post(f"{path}/queue", json=item).raise_for_status()
    waiting = stage.page.locator("#queue > li")
    expect(waiting).to_have_text([f"{NAME}12", "Ben900"])
    expect(stage.page.locator("#queue-title")).to_have_text("Waiting: 912 (paused)")
    for size in FRAMES[3:]:  # the same shape as the first
        stage.page.set_viewport_size(size)
        stage.frames(4)
        found = stage.page.evaluate(_LAID_OUT)
        assert found["beyond"] <= 0, size
        assert found["fills"] > 0.99, size
        stage.shot(f"stage-queue-{size['width']}x{size['height']}")
    http.patch(f"{path}/queue", json={"paused": False}).raise_for_status()
    expect(stage.page.locator("#winners > li").first).to_contain_text(NAME)
    mortal.end(signal.SIGKILL)
    stage.state("reconnecting")
    mortal.start()
    there(stage)
    expect(waiting).to_have_count(1)
    http.post(f"{path}/queue/clear").raise_for_status()
    expect(waiting).to_have_count(0)
    names = [drop["name"] for drop in http.get(f"{path}/log").json()["drops"]]
    http.close()
    assert names[:12] == [NAME] * 12
    assert set(names[12:]) <= {"Ben"}
    player.ready()


def visitor(name: str, colour: str) -> str:
    """A script for a page to run first, which sets the visitor's name and colour."""
    chosen = json.dumps({"name": name, "colour": colour})
    return f"localStorage.setItem('plinko.visitor.1', {json.dumps(chosen)})"


def painted(stage: Screen, pupils: dict[str, str]) -> list[int]:
    """How many pixels below the board have each pupil's colour."""
    counts: list[int] = stage.page.evaluate(_PAINTED, list(pupils.values()))
    return counts


def shows_all(stage: Screen, pupils: dict[str, str]) -> bool:
    return all(painted(stage, pupils))


def test_phones_join_by_the_code_each_with_its_colour(opened: Open, server: Address) -> None:
    board = Board.preset("triangle-8").replace(name="class").to_dict()
    room = httpx.post(f"{server.url}/api/v1/rooms", json={"board": board}, timeout=LIMIT).json()
    address = f"/stage.html?room={room['id']}&leaders=balls&join=on"
    pile = there(opened(f"{address}&tray=pile&expected=binomial"))
    bars = there(opened(f"{address}&tray=bars&expected=on"))
    code = httpx.get(pile.page.locator("#join").evaluate("image => image.src"), timeout=LIMIT)
    link = read(code.text)
    pupils = {"Ada": "#ff2040", "Ben": "#c040ff"}
    for name, colour in pupils.items():
        phone = opened(link, before=visitor(name, colour), viewport={"width": 390, "height": 844})
        phone.ready()
        for _ in range(4):
            phone.drop.click()
    for stage, expected in ((pile, "Expected (binomial, 8 rows)"), (bars, "Expected (measured, ")):
        expect(stage.page.locator("#leaders > li")).to_have_text(2 * [re.compile("^(Ada|Ben)4$")])
        expect(stage.page.locator("#tray-count")).to_have_text("8 balls landed at this table")
        expect(stage.page.locator("#tray-key")).to_contain_text(expected)
        until(partial(shows_all, stage, pupils), partial(stage.frames, 4))
        check_axe(stage)
        for size in FRAMES:
            stage.page.set_viewport_size(size)
            stage.frames(4)
            found = stage.page.evaluate(_LAID_OUT)
            assert found["beyond"] < 1, size
            assert found["fills"] > 0.99, size
            assert found["lesson"] > 0.25, size
    ada, ben = painted(bars, pupils)
    assert 0.8 < ada / ben < 1.25, "four balls each, of the same height"
    pile.shot("stage-pile")
    bars.shot("stage-bars")


def test_the_address_switches_each_part_and_chooses_the_ground(opened: Open) -> None:
    bare = there(
        opened("/stage.html?room=triangle-8&winners=off&leaders=off&queue=off&ground=transparent")
    )
    expect(bare.page.locator(".show-panel:not([hidden])")).to_have_count(0)
    clear, all_of_it = "rgba(0, 0, 0, 0)", 255
    assert grounds(bare) == {"around": 0, "plate": all_of_it, "below": [clear]}
    page = bare.page
    page.goto(f"{bare.url}/stage.html?room=triangle-8&ground=00b140&plate=off")
    there(bare)
    expect(page.locator(".show-panel:not([hidden])")).to_have_count(3)
    assert grounds(bare) == {"around": 0, "plate": 0, "below": ["rgb(0, 177, 64)"]}
    page.goto(f"{bare.url}/stage.html?room=triangle-8")
    found = grounds(bare)
    assert (found["around"], found["plate"]) == (all_of_it, all_of_it)


def test_a_missing_room_is_reported_and_polled(opened: Open, complaints: Complaints) -> None:
    complaints.allow("WebSocket|404")
    stage = opened(
        "/stage.html?room=nowhere", before="window.setTimeout = (run) => { again = run; };"
    )
    stage.state("closed")
    expect(stage.result).to_contain_text("This room is not open")
    with stage.page.expect_navigation():
        stage.page.evaluate("again()")


def test_a_stage_comes_back_by_itself_and_goes_on_with_its_lists(
    opened: Open, mortal: ServerProcess, complaints: Complaints
) -> None:
    complaints.allow(GONE)
    quick = quick_table(mortal, "triangle-8")
    stage = there(opened(f"{mortal.url}/stage.html?room={quick.room}&leaders=balls"))
    player = opened(f"{mortal.url}{quick.page}", before=_NAMED).ready()
    leaders = stage.page.locator("#leaders > li")
    player.drop.click()
    expect(leaders).to_have_text(f"{NAME}1")
    mortal.end(signal.SIGKILL)
    stage.state("reconnecting")
    expect(stage.result).to_contain_text("Connection lost")
    mortal.start()
    there(stage)
    expect(stage.result).to_have_text("")
    player.ready()
    player.drop.click()
    expect(leaders).to_have_text(f"{NAME}2")
