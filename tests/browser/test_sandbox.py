"""The sandbox: throws, sliders, pause, the energy plot, keys, every screen."""

import json
import re
import urllib.request
from typing import Any

import pytest
from playwright.sync_api import expect

from plinko.app.cli import main
from tests.browser.access.axe import check_axe_on
from tests.browser.conftest import Open, holding, quick_table
from tests.browser.looks import SCREENS, check_fit, context_for, each_screen, painted
from tests.browser.screen import Screen
from tests.kit.address import Address
from tests.kit.process import OPERATOR

# Nothing comes to rest, so the page keeps drawing for as long as a slow machine needs.
RESTLESS = {"restitution": 1, "friction": 0}


def own_room(server: Address, **scene: Any) -> tuple[str, str]:
    """Create a sandbox room; returns its id, and a script that gives a page the owner's token."""
    request = urllib.request.Request(
        f"{server.url}/api/v1/rooms",
        json.dumps({"scene": {"scene": "sandbox", **scene}}).encode(),
        {"content-type": "application/json"},
    )
    with urllib.request.urlopen(request) as reply:
        room = json.load(reply)
    return room["id"], holding(room["id"], room["token"])


@pytest.fixture
def box(opened: Open, server: Address) -> Any:
    """Opens a page on a new sandbox room with this scene."""

    def open_box(scene: dict[str, Any], **options: Any) -> Screen:
        room, before = own_room(server, **scene)
        screen = opened(f"/sandbox.html?room={room}", before=before, **options)
        # Until the room is loaded the page does not know whether it is locked, and ignores input.
        expect(screen.root).to_have_attribute("data-locked", "false")
        return screen

    return open_box


def canvas_box(screen: Screen) -> dict[str, float]:
    found = screen.page.locator("#board-moving").bounding_box()
    assert found is not None
    return {name: found[name] for name in ("x", "y", "width", "height")}


def told(screen: Screen, kind: str) -> list[dict[str, Any]]:
    """The messages of this type that the page sent."""
    messages = [json.loads(frame) for frame in screen.sent if isinstance(frame, str)]
    return [message for message in messages if message["type"] == kind]


def balls(screen: Screen, count: int) -> None:
    """Wait until the page shows this number of balls."""
    name = re.compile(f"Box with {count} balls?")
    expect(screen.page.locator("#board-moving")).to_have_attribute("aria-label", name)


def test_a_ball_is_thrown_by_pulling_from_an_empty_place(box: Any) -> None:
    screen = box({"balls": 0, "gravity": 0, "restitution": 1})
    at = canvas_box(screen)
    x, y = at["x"] + 0.3 * at["width"], at["y"] + 0.5 * at["height"]
    screen.page.mouse.move(x, y)
    screen.page.mouse.down()
    screen.page.mouse.move(x + 80, y, steps=4)
    screen.page.mouse.up()
    balls(screen, 1)
    (sent,) = told(screen, "add")
    assert sent["vx"] > 2.0
    assert abs(sent["vy"]) < 0.2
    expect(screen.result).to_contain_text("Thrown at")
    first = screen.ball()
    screen.until(lambda: abs(screen.ball()[0] - first[0]) > 20)  # it flies


def test_a_ball_is_dragged_and_thrown_and_a_tap_puts_one_down(box: Any) -> None:
    screen = box({"balls": 0, "gravity": 0})
    at = canvas_box(screen)
    x, y = at["x"] + 0.4 * at["width"], at["y"] + 0.4 * at["height"]
    screen.page.mouse.click(x, y)
    balls(screen, 1)
    (sent,) = told(screen, "add")
    assert (sent["vx"], sent["vy"]) == (0, 0)
    screen.frames(2)  # erases the preview of the throw
    screen.until(lambda: painted(screen, "board-moving"))  # the picture follows the event
    screen.page.mouse.move(x, y)
    screen.page.mouse.down()
    for step in range(1, 12):
        screen.page.mouse.move(x + 12 * step, y)
        screen.frames(1)
    screen.until(lambda: screen.ball()[0] > x - at["x"] + 20)  # the ball follows the pointer
    screen.page.mouse.up()
    expect(screen.page.locator("#ball-title")).to_contain_text("Ball 0")
    screen.until(lambda: told(screen, "release"))
    assert told(screen, "drag")
    screen.page.get_by_role("button", name="Remove it").click()
    balls(screen, 0)
    assert told(screen, "release") == [{"type": "release", "ball": 0}]


def test_everyone_has_a_box_of_their_own_that_moves_into_a_room(
    opened: Open, server: Address
) -> None:
    screen = opened("/sandbox.html")
    balls(screen, 60)
    # After 2 s of the sandbox's time no falling ball is where the new one is put.
    expect(screen.fact("time")).to_have_text(re.compile(r"^([2-9]|\d\d)"))
    at = canvas_box(screen)
    screen.page.mouse.click(at["x"] + 0.5 * at["width"], at["y"] + 0.05 * at["height"])
    balls(screen, 61)
    screen.page.get_by_role("button", name="Pause").click()
    assert not screen.sent  # the page needed no server
    screen.page.get_by_role("button", name="Share this box").click()
    screen.page.wait_for_url("**/sandbox.html?room=*")
    balls(screen, 61)
    expect(screen.page.locator("#share-link")).to_have_value(screen.page.url)
    expect(screen.page.get_by_role("button", name="Resume")).to_be_enabled()
    room = screen.page.url.split("room=")[1]
    with urllib.request.urlopen(f"{server.url}/api/v1/rooms/{room}/log") as reply:
        log = json.load(reply)
    assert [each["input"]["type"] for each in log["inputs"]] == ["add", "pause"]
    guest = opened(f"/sandbox.html?room={room}")
    balls(guest, 61)


def test_a_missing_room_is_reported_with_links(opened: Open) -> None:
    screen = opened("/sandbox.html?room=nosuch")
    expect(screen.result).to_contain_text("There is no room nosuch")
    screen.page.locator("#room-links").get_by_role("link", name="Open my own box").click()
    balls(screen, 60)


def test_sliders_and_presets_set_the_room_for_everyone(box: Any, opened: Open) -> None:
    screen = box({"balls": 3})
    room = screen.page.url.split("room=")[1]
    guest = opened(f"/sandbox.html?room={room}")
    expect(guest.page.locator("#locked")).to_be_visible()
    screen.page.get_by_label("Gravity of").select_option("Jupiter")
    shown = re.compile(r"24\.79 m/s²")
    for page in (screen.page, guest.page):
        expect(page.locator("output[for=world-sliders-gravity]")).to_have_text(shown)
    slider = screen.page.get_by_label("Bounce", exact=True).first
    slider.focus()
    slider.press("Home")
    expect(guest.page.locator("output[for=world-sliders-restitution]")).to_have_text("0")
    expect(guest.page.get_by_role("button", name="Throw a ball")).to_be_disabled()


def test_a_dozen_controls_are_in_sight_and_the_rest_behind_more(box: Any) -> None:
    page = box({"balls": 3}).page
    controls = page.locator(".desk :is(button, input, select)").filter(visible=True)
    assert 10 <= controls.count() <= 12
    expect(page.get_by_label("Friction")).to_have_count(2)
    expect(page.get_by_label("Friction").first).to_be_hidden()
    page.get_by_role("heading", name="More").click()
    expect(page.get_by_label("Friction").filter(visible=True)).to_have_count(1)
    expect(page.get_by_label("Substeps")).to_be_visible()


# How many colours of clear hue the balls have, of more than 60 pixels each, in steps of 30 degrees.
_HUES = """
() => {
  const canvas = document.getElementById("board-moving");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const counts = new Array(12).fill(0);
  for (let i = 0; i < data.length; i += 4) {
    const [red, green, blue] = data.subarray(i, i + 3);
    const [most, least] = [Math.max(red, green, blue), Math.min(red, green, blue)];
    if (data[i + 3] < 250 || most - least < 90) continue;
    const sixth = most === red ? (green - blue) / (most - least)
      : most === green ? 2 + (blue - red) / (most - least) : 4 + (red - green) / (most - least);
    counts[Math.floor(((sixth + 6) % 6) * 2)] += 1;
  }
  return counts.filter((count) => count > 60).length;
}
"""


def test_balls_are_coloured_by_their_size(box: Any) -> None:
    alike = box({"balls": 20, "radii": [0.12, 0.12], **RESTLESS})
    alike.until(lambda: painted(alike, "board-moving"))
    same = alike.page.evaluate(_HUES)
    mixed = box({"balls": 40, "radii": [0.05, 0.2], **RESTLESS})
    mixed.until(lambda: painted(mixed, "board-moving"))
    assert mixed.page.evaluate(_HUES) >= same + 3


def test_pause_stops_step_goes_one_tick_and_reset_restarts(box: Any) -> None:
    screen = box({"balls": 20})
    page = screen.page
    page.get_by_role("heading", name="More").click()
    page.get_by_role("button", name="Pause").click()
    screen.state("paused")
    time = screen.fact("time")
    expect(time).to_have_text(re.compile(r"\d"))
    shown = [time.inner_text()]
    for _ in range(2):
        page.get_by_role("button", name="Step").click()
        expect(time).not_to_have_text(shown[-1])
        shown.append(time.inner_text())
    # A time from before the pause may be shown after it: ignore the first.
    _, one, two = (float(text.split()[0]) for text in shown)
    assert 0 < two - one < 0.05
    page.get_by_role("button", name="Resume").click()
    screen.state("live", "asleep")
    page.get_by_role("button", name="Clear").click()
    balls(screen, 0)
    page.get_by_role("button", name="Reset").click()
    balls(screen, 20)


def test_energy_momentum_and_the_rest_are_measured(box: Any) -> None:
    screen = box({"balls": 30, "restitution": 0.5})
    screen.page.get_by_role("heading", name="More").click()
    expect(screen.fact("asleep")).to_have_text(re.compile(r"\d+ of 30"))
    screen.state("asleep")
    expect(screen.fact("asleep")).to_have_text("30 of 30")
    expect(screen.fact("kinetic")).to_have_text(re.compile(r"^0\.00 "))
    expect(screen.fact("momentum")).to_have_text("0.00 kg m/s")
    overlap = float(screen.fact("deepest-overlap").inner_text().split()[0])
    assert overlap < 2.0, "millimetres"
    assert painted(screen, "energy") > 500
    expect(screen.page.locator("#energy")).to_have_attribute("aria-label", re.compile("joules"))
    expect(screen.result).to_have_text("Everything is at rest.")


def test_a_game_by_keyboard_alone(box: Any) -> None:
    screen = box({"balls": 0, "gravity": 0})
    page = screen.page
    canvas = page.locator("#board-moving")
    for _ in range(12):
        page.keyboard.press("Tab")
        if canvas.evaluate("canvas => canvas === document.activeElement"):
            break
    expect(canvas).to_be_focused()
    for _ in range(3):
        page.keyboard.press("Shift+ArrowLeft")
    page.keyboard.press("Enter")
    balls(screen, 1)
    (sent,) = told(screen, "add")
    assert sent["x"] == pytest.approx(-1.5)
    screen.ball()  # the picture follows the event
    page.keyboard.press("g")
    expect(screen.result).to_contain_text("Ball 0 is grabbed")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("g")
    # It may come to rest before the line is read.
    expect(screen.result).to_have_text(re.compile(r"Released\.|at rest"))
    assert told(screen, "drag")
    assert told(screen, "release") == [{"type": "release", "ball": 0}]
    page.keyboard.press("k")
    expect(screen.result).to_have_text("Kicked ball 0.")
    page.keyboard.press("p")
    screen.state("paused")
    page.keyboard.press(".")
    assert told(screen, "step") == [{"type": "step"}]
    page.keyboard.press("p")
    screen.state("live", "asleep")
    page.keyboard.press("Delete")
    balls(screen, 0)


def test_another_scene_is_begun_from_the_form(box: Any) -> None:
    screen = box({"balls": 2})
    page = screen.page
    page.get_by_role("heading", name="More").click()
    page.get_by_label("Balls", exact=True).fill("12")
    page.get_by_label("Width, m").fill("3")
    page.get_by_role("button", name="Begin", exact=True).click()
    balls(screen, 12)
    page.get_by_label("Balls", exact=True).fill("4000")
    page.get_by_role("button", name="Begin", exact=True).click()
    expect(screen.result).to_contain_text("4000")


def test_another_table_has_balls_that_knock_each_other(opened: Open) -> None:
    table = opened("/?room=triangle-8").ready()
    table.drawer("Table").get_by_role("radio", name="Balls collide (practice)").check(force=True)
    expect(table.page).to_have_url(re.compile("room=interacting-triangle-8"))
    table.ready()


def test_a_board_of_touching_balls_is_played_and_halted_on_pages(
    opened: Open, server: Address, monkeypatch: pytest.MonkeyPatch
) -> None:
    quick = quick_table(server, "triangle-8", "interacting")
    table = opened(quick.page).ready()
    expect(table.drop).to_contain_text("Practice")
    expect(table.page.locator("#practice-note")).to_contain_text("balls collide here")
    for hidden in ("#stake", "#padlock"):
        expect(table.page.locator(hidden)).to_be_hidden()
    table.drop.click()
    expect(table.rows).to_have_count(1)
    expect(table.result).to_contain_text("(practice)")
    expect(table.page.locator("#staked")).to_have_text("0.00")
    expect(table.rows.first).to_contain_text("hit by another ball")
    screen = opened(f"/sandbox.html?room={quick.room}", before=holding(quick.room, quick.token))
    expect(screen.page.locator("#title")).to_contain_text("quick")
    screen.page.get_by_role("button", name="Drop one").click()
    expect(screen.result).to_have_text(re.compile(r"fell into bin \d|came to rest"))
    monkeypatch.setenv("PLINKO_OPERATOR_TOKEN", OPERATOR)
    assert main(["halt", server.url, "--room", quick.room]) == 0
    expect(screen.result).to_have_text(
        "This table is paused and takes no balls. Balls in flight still land."
    )


@pytest.mark.long
@pytest.mark.parametrize("device", SCREENS)
def test_fits_every_screen(box: Any, device: str) -> None:
    screen = box({"balls": 40}, **context_for(device))
    expect(screen.fact("asleep")).to_have_text(re.compile("of 40"))
    screen.page.get_by_role("heading", name="More").click()
    for name in each_screen(screen, device):
        check_fit(screen)
        check_axe_on(screen, name)
        screen.shot(f"sandbox-{name}")


def test_those_who_want_no_motion_see_pictures_now_and_then(box: Any) -> None:
    screen = box({"balls": 30, **RESTLESS}, reduced_motion="reduce")
    balls(screen, 30)
    between = screen.page.evaluate(
        """async () => {
          const ctx = document.querySelector("#board-moving").getContext("2d");
          const { clearRect } = ctx;
          const at = [];
          ctx.clearRect = (...box) => {
            at.push(document.timeline.currentTime);
            clearRect.apply(ctx, box);
          };
          while (at.length < 5) await new Promise(requestAnimationFrame);
          return at.slice(1).map((time, i) => time - at[i]);
        }"""
    )
    assert min(between) >= 399, "milliseconds from picture to picture"


def test_five_hundred_balls_are_drawn_again_and_again(box: Any) -> None:
    screen = box({"balls": 500, "radii": [0.03, 0.08], **RESTLESS})
    balls(screen, 500)
    drawn = screen.page.evaluate(
        """async () => {
          const ctx = document.querySelector("#board-moving").getContext("2d");
          const { clearRect, drawImage } = ctx;
          let [frames, stamps] = [0, 0];
          ctx.clearRect = (...box) => { frames += 1; clearRect.apply(ctx, box); };
          ctx.drawImage = (...what) => { stamps += 1; drawImage.apply(ctx, what); };
          while (frames < 20) await new Promise(requestAnimationFrame);
          return stamps / frames;
        }"""
    )
    assert 450 <= drawn <= 530, "one stamp a ball and frame"
