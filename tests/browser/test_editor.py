"""The editor: boards are made by pointer and keys, checked, tested, shared and played."""

import json
import re
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Route, expect

from plinko.engine import Board, drop_many
from tests.browser.access.axe import check_axe, check_axe_on
from tests.browser.conftest import Complaints, Open
from tests.browser.looks import SCREENS, check_fit, context_for, each_screen
from tests.browser.screen import Screen

_BOARD = """
async () => {
  const { unpackBoard, boardInHash } = await import("/js/net/board-link.js");
  return unpackBoard(boardInHash(location.hash));
}
"""

# Metres to CSS pixels of the field, by the page's layout of the board in the address.
_PLACES = """
async (points) => {
  const { BELOW } = await import("/js/editor/marks.js");
  const { layOut } = await import("/js/paint/geometry.js");
  const { unpackBoard, boardInHash } = await import("/js/net/board-link.js");
  const board = await unpackBoard(boardInHash(location.hash));
  const field = document.querySelector("#field");
  const { px, py, height } = layOut(board, field.clientWidth);
  // Parts above the start move the picture down; knobs are below the bins.
  const more = field.clientHeight - height - BELOW;
  return points.map(([x, y]) => [px(x), py(y) + more]);
}
"""


class Bench:
    """The editor as its user sees it."""

    def __init__(self, screen: Screen) -> None:
        self.screen = screen
        self.page = screen.page
        self.field = screen.page.locator("#field")
        screen.state("asleep")
        self.checked("good")

    @property
    def board(self) -> Any:
        """The board in the address, which is the link to share."""
        return self.page.evaluate(_BOARD)

    def checked(self, verdict: str) -> None:
        expect(self.screen.root).to_have_attribute("data-check", verdict)

    def tool(self, name: str) -> None:
        self.page.get_by_role("radio", name=name, exact=True).check()

    def places(self, *points: list[float]) -> list[list[float]]:
        """Metres as CSS pixels of the field."""
        found: list[list[float]] = self.page.evaluate(_PLACES, list(points))
        return found

    def click(self, x: float, y: float) -> None:
        ((left, top),) = self.places([x, y])
        self.field.click(position={"x": left, "y": top})

    def drag(self, start: list[float], end: list[float]) -> None:
        box = self.field.bounding_box()
        assert box is not None
        from_, to = self.places(start, end)
        mouse = self.page.mouse
        mouse.move(box["x"] + from_[0], box["y"] + from_[1])
        mouse.down()
        mouse.move(box["x"] + (from_[0] + to[0]) / 2, box["y"] + (from_[1] + to[1]) / 2)
        mouse.move(box["x"] + to[0], box["y"] + to[1])
        mouse.up()

    def becomes(self, path: str, value: Any) -> None:
        """Wait until the part of the address's board at this path has this value."""
        wanted = json.dumps(value, ensure_ascii=False, separators=(",", ":"))
        self.until(f"JSON.stringify(board.{path}) === arg", wanted)

    def until(self, condition: str, arg: Any = None) -> None:
        """Wait until a JavaScript condition on `board`, the address's board, and `arg` holds."""
        # Not `wait_for_function`: it takes the promise of an asynchronous function for true.
        fulfilled = self.page.evaluate(
            f"""async (arg) => {{
              const deadline = performance.now() + 30_000;
              for (;;) {{
                const board = await ({_BOARD})();
                if ({condition}) return true;
                if (performance.now() > deadline) return false;
                await new Promise(requestAnimationFrame);
              }}
            }}""",
            arg,
        )
        assert fulfilled, f"{condition} for {arg!r}, of {self.board}"

    def press(self, *keys: str) -> None:
        for key in keys:
            self.page.keyboard.press(key)


@pytest.fixture
def bench(opened: Open) -> Bench:
    return Bench(opened("/editor.html", viewport={"width": 1280, "height": 720}))


def test_pegs_are_placed_moved_and_deleted_with_the_pointer(bench: Bench) -> None:
    pegs = bench.board["pegs"]
    bench.tool("Peg")
    bench.click(0.52, 1.98)
    added = {"x": 0.5, "y": 2, "radius": pegs[-1]["radius"]}
    bench.becomes("pegs", [*pegs, added])
    expect(bench.page.locator("#selected-title")).to_have_text(f"Peg {len(pegs)}")

    bench.tool("Move")
    bench.drag([0.5, 2.0], [-0.75, 1.85])
    bench.becomes("pegs.at(-1)", {**added, "x": -0.75, "y": 1.85})
    bench.screen.shot("editor-peg")
    bench.page.get_by_role("button", name="Delete").click()
    bench.becomes("pegs", pegs)
    bench.checked("good")


def test_bins_are_made_moved_paid_and_joined(bench: Bench) -> None:
    bins = bench.board["bins"]
    bench.tool("Bin")
    bench.click(0.0, bins["y"] + 0.1)
    bench.becomes("bins.edges", [-1.5, -0.5, 0, 0.5, 1.5])
    bench.becomes("bins.multipliers", [2, 0.5, 0.5, 2])
    bench.tool("Move")
    bench.drag([0.0, bins["y"] + 0.2], [0.2, bins["y"] + 0.2])
    bench.becomes("bins.edges", [-1.5, -0.5, 0.2, 0.5, 1.5])
    bench.click(-1.0, bins["y"] + 0.2)
    pays = bench.page.get_by_label("Pays")
    pays.fill("7.5")
    pays.press("Enter")
    bench.becomes("bins.multipliers", [7.5, 0.5, 0.5, 2])
    bench.click(0.2, bins["y"] + 0.2)
    bench.page.get_by_role("button", name="Delete").click()
    bench.becomes("bins.multipliers", [7.5, 0.5, 2])
    bench.becomes("bins.edges", [-1.5, -0.5, 0.5, 1.5])


def test_a_bin_gets_a_prize_and_a_colour_and_loses_them_again(bench: Bench) -> None:
    bench.click(-1.0, bench.board["bins"]["y"] + 0.2)
    fields = bench.page.locator("#selected-fields")
    prize = fields.get_by_label("Prize", exact=True)
    prize.fill("<b>Mug</b> \U0001f381")
    prize.press("Enter")
    bench.becomes("bins.labels", [{"text": "<b>Mug</b> \U0001f381"}, None, None])
    colour = fields.get_by_label("Prize colour")
    colour.fill("#ff0088")
    colour.press("Enter")
    bench.becomes("bins.labels[0]", {"text": "<b>Mug</b> \U0001f381", "colour": "#ff0088"})
    bench.checked("good")
    bench.screen.shot("editor-prize")
    prize.fill("")
    prize.press("Enter")
    bench.until("!('labels' in board.bins)")
    expect(colour).to_have_count(0)


def test_walls_are_drawn_and_their_ends_moved(bench: Bench) -> None:
    walls = bench.board["walls"]
    bench.tool("Wall")
    bench.drag([-1.0, 1.9], [-0.5, 2.1])
    bench.becomes("walls.at(-1)", {"x1": -1, "y1": 1.9, "x2": -0.5, "y2": 2.1})
    bench.tool("Move")
    bench.drag([-0.5, 2.1], [-0.6, 2.05])
    bench.becomes("walls.at(-1)", {"x1": -1, "y1": 1.9, "x2": -0.6, "y2": 2.05})
    bench.press("Delete")
    bench.becomes("walls", walls)
    bench.tool("Wall")
    bench.click(0.8, 1.0)
    expect(bench.screen.result).to_contain_text("two ends")
    assert bench.board["walls"] == walls


def test_a_whole_board_is_edited_by_keyboard_alone(bench: Bench) -> None:
    pegs = bench.board["pegs"]
    for _ in range(12):
        if bench.field.evaluate("field => field === document.activeElement"):
            break
        bench.press("Tab")
        if bench.page.evaluate("document.activeElement.value === 'move'"):
            bench.press("ArrowRight")  # the tool for pegs
    expect(bench.field).to_be_focused()
    bench.press("Shift+ArrowDown", "ArrowRight", "Enter")
    added = bench.board["pegs"]
    assert len(added) == len(pegs) + 1
    new = added[-1]
    bench.press(
        "ArrowLeft", "ArrowLeft", "ArrowLeft", "ArrowLeft", "ArrowLeft", "ArrowLeft", "Enter"
    )
    bench.becomes("pegs.at(-1).x", round(new["x"] - 0.3, 6))

    bench.press("PageDown", "PageDown")
    expect(bench.page.locator("#selected-title")).to_have_text("Peg 0")
    bench.press("ArrowDown", "ArrowDown")
    bench.becomes("pegs[0].y", round(pegs[0]["y"] + 0.1, 6))
    expect(bench.screen.result).to_contain_text("Peg 0 of")
    bench.press("Delete")
    bench.becomes("pegs.length", len(pegs) + 1)
    for _ in range(4):
        bench.press("Control+z")
    bench.becomes("pegs", [*pegs, new])
    bench.press("Control+y", "Control+y", "Control+y")
    bench.becomes("pegs[0].y", round(pegs[0]["y"] + 0.1, 6))
    bench.press("Control+z", "Control+z", "Control+z", "Control+z")
    bench.becomes("pegs", pegs)
    bench.press("Control+z")
    expect(bench.screen.result).to_contain_text("Nothing to undo")


def test_several_parts_are_moved_copied_and_deleted_together(
    bench: Bench, complaints: Complaints
) -> None:
    pegs, walls = bench.board["pegs"], bench.board["walls"]
    title = bench.page.locator("#selected-title")
    bench.tool("Move")
    bench.click(pegs[1]["x"], pegs[1]["y"])
    bench.page.keyboard.down("Shift")
    bench.click(pegs[2]["x"], pegs[2]["y"])
    bench.click(walls[0]["x1"], 1.0)
    expect(title).to_have_text("2 pegs and 1 wall")
    bench.click(walls[0]["x1"], 1.0)
    bench.page.keyboard.up("Shift")
    expect(title).to_have_text("2 pegs")

    bench.drag([pegs[2]["x"], pegs[2]["y"]], [pegs[2]["x"] + 0.2, pegs[2]["y"] + 0.3])
    lower = [{**peg, "x": round(peg["x"] + 0.2, 6), "y": round(peg["y"] + 0.3, 6)}
             for peg in pegs[1:]]  # fmt: skip
    bench.becomes("pegs", [pegs[0], *lower])
    bench.page.get_by_role("button", name="Duplicate").click()
    bench.becomes("pegs.length", 5)
    expect(title).to_have_text("2 pegs")
    copies = bench.board["pegs"][3:]
    assert [peg["y"] for peg in copies] == [peg["y"] for peg in lower]
    assert all(copy["x"] > peg["x"] for copy, peg in zip(copies, lower, strict=True))
    bench.screen.shot("editor-group")
    bench.page.get_by_role("button", name="Delete").click()
    bench.becomes("pegs", [pegs[0], *lower])
    bench.page.get_by_role("button", name="Undo").click()
    bench.becomes("pegs.length", 5)
    bench.checked("bad")
    complaints.allow("422")  # copies overlap until they are moved


def test_a_rectangle_over_empty_board_selects_what_it_is_around(bench: Bench) -> None:
    pegs = bench.board["pegs"]
    title = bench.page.locator("#selected-title")
    bench.tool("Move")
    bench.drag([-0.9, 1.1], [0.9, 1.7])
    expect(title).to_have_text("2 pegs")
    bench.field.focus()
    bench.press("ArrowDown", "ArrowDown")
    bench.becomes("pegs[1].y", round(pegs[1]["y"] + 0.1, 6))
    bench.becomes("pegs[2].y", round(pegs[2]["y"] + 0.1, 6))
    assert bench.board["pegs"][0] == pegs[0]
    bench.drag([-0.9, 1.8], [-0.7, 2.0])
    expect(title).to_have_text("Nothing selected")


def test_several_parts_are_selected_by_keys(bench: Bench) -> None:
    pegs = bench.board["pegs"]
    title = bench.page.locator("#selected-title")
    bench.tool("Move")
    bench.field.focus()
    bench.press("PageDown", "PageDown", "Shift+PageDown")
    expect(title).to_have_text("2 pegs")
    expect(bench.screen.result).to_have_text("2 pegs selected.")
    bench.press("ArrowRight")
    bench.becomes("pegs[0].x", round(pegs[0]["x"] + 0.05, 6))
    bench.becomes("pegs[1].x", round(pegs[1]["x"] + 0.05, 6))
    bench.press("Control+a")
    expect(title).to_have_text("The start, 3 pegs and 2 walls")
    bench.press("Delete")
    bench.becomes("pegs", [])
    bench.becomes("walls", [])
    bench.press("Control+z", "Control+z")
    bench.becomes("pegs", pegs)


def test_a_wall_and_a_bin_are_placed_by_keys(bench: Bench) -> None:
    bench.tool("Wall")
    bench.field.focus()
    bench.press("Enter", "Shift+ArrowLeft", "ArrowDown", "Enter")
    bench.becomes("walls.length", 3)
    wall = bench.board["walls"][-1]
    assert wall["x2"] == pytest.approx(wall["x1"] - 0.5)
    assert wall["y2"] == pytest.approx(wall["y1"] + 0.05)
    bench.tool("Bin")
    bench.field.focus()
    bench.press("ArrowRight", "Enter")
    bench.becomes("bins.edges.length", 5)


def test_a_changed_board_has_no_verdict_until_its_own_comes(bench: Bench) -> None:
    held: list[Route] = []

    def hold(route: Route) -> None:
        held.append(route)

    bench.page.route(re.compile("/boards/check$"), hold)
    bench.tool("Peg")
    bench.click(0.0, 2.0)
    bench.screen.until(lambda: held)
    bench.checked("asked")
    held.pop().continue_()
    bench.checked("good")


def test_a_refusal_is_shown_at_the_place_it_is_about(bench: Bench, complaints: Complaints) -> None:
    peg = bench.board["pegs"][0]
    bench.tool("Peg")
    bench.click(peg["x"] + 0.3, peg["y"])
    x = bench.page.get_by_label("x, m")
    x.fill(str(peg["x"] + 0.05))
    x.press("Enter")
    bench.checked("bad")
    bubble = bench.page.locator("#bubble")
    expect(bubble).to_contain_text("overlaps")
    expect(bench.page.locator("#check-text")).to_contain_text("overlaps")
    at, box, field = (
        bench.places([peg["x"], peg["y"]])[0],
        bubble.bounding_box(),
        bench.field.bounding_box(),
    )
    assert box is not None
    assert field is not None
    assert box["x"] - 10 <= field["x"] + at[0] <= box["x"] + box["width"] + 10
    assert abs(box["y"] - field["y"] - at[1]) < 60
    check_axe(bench.screen)
    bench.screen.shot("editor-problem")
    bench.press("Escape")
    bench.page.get_by_role("button", name="Show where").click()
    expect(bench.page.locator("#selected-title")).to_have_text(re.compile("^Peg "))
    bench.press("Delete")
    bench.checked("good")
    expect(bubble).to_be_hidden()
    complaints.allow("422")


def test_a_refusal_of_a_number_is_shown_at_its_field(bench: Bench, complaints: Complaints) -> None:
    radius = bench.page.get_by_label("Ball radius, m")
    radius.fill("-1")
    radius.press("Enter")
    bench.checked("bad")
    expect(radius).to_have_attribute("aria-invalid", "true")
    expect(bench.page.locator("#check-text")).to_contain_text("ball.radius is -1")
    bench.page.get_by_role("button", name="Show where").click()
    expect(radius).to_be_focused()
    radius.fill("much")
    radius.press("Enter")
    expect(bench.page.locator("#at-ball-radius-note")).to_contain_text("“much” is not a number")
    bench.page.get_by_role("button", name="Undo").click()
    bench.checked("good")
    expect(radius).to_have_attribute("aria-invalid", "false")
    complaints.allow("422")


def test_a_hundred_balls_are_dropped_at_once_and_counted(bench: Bench) -> None:
    test = bench.page.get_by_role("button", name="Test-drop")
    test.click()
    count = bench.page.locator("#tray-count")
    expect(count).to_have_text("100 test balls")
    board = Board.from_json(bench.board)
    first = drop_many(board, range(100))
    histogram = bench.page.locator("#histogram")
    told = ", ".join(f"bin {bin_}: {n}" for bin_, n in enumerate(first.histogram))
    expect(histogram).to_have_attribute("aria-label", re.compile(re.escape(told)))
    expect(bench.page.locator("#tray-numbers")).to_contain_text(
        f"return {100 * first.score.mean():.1f} %"
    )
    test.click()
    expect(count).to_have_text("200 test balls")
    both = drop_many(board, range(200))
    told = ", ".join(f"bin {bin_}: {n}" for bin_, n in enumerate(both.histogram))
    expect(histogram).to_have_attribute("aria-label", re.compile(re.escape(told)))
    bench.screen.shot("editor-test")

    bench.tool("Peg")
    bench.click(0.0, 2.0)
    expect(count).to_have_text("No test yet")


def test_the_address_is_a_link_that_opens_the_same_board(bench: Bench, opened: Open) -> None:
    bench.tool("Peg")
    bench.click(0.0, 2.0)
    bench.becomes("pegs.length", 4)
    bench.page.get_by_role("button", name="Copy link").click()
    link = bench.page.get_by_label("Link containing the board")
    expect(link).to_have_value(bench.page.url)
    board = bench.board
    other = Bench(opened(bench.page.url.removeprefix(bench.screen.url)))
    assert other.board == board
    other.page.get_by_role("link", name="Replay").click()
    other.screen.state("replay")
    record = other.page.request.post(
        f"{other.screen.url}/api/v1/drops", data={"board": board, "seed": "1"}
    ).json()
    expect(other.screen.fact("digest")).to_have_text(record["digest"])


def test_a_board_is_saved_and_loaded_as_json(bench: Bench, tmp_path: Path) -> None:
    bench.tool("Peg")
    bench.click(0.0, 2.0)
    bench.becomes("pegs.length", 4)
    with bench.page.expect_download() as download:
        bench.page.get_by_role("button", name="Save JSON").click()
    path = tmp_path / "board.json"
    download.value.save_as(path)
    board = bench.board
    assert json.loads(path.read_text()) == board
    assert Board.from_json(path).name == board["name"]

    bench.press("Control+z")
    bench.becomes("pegs.length", 3)
    bench.page.locator("#file").set_input_files(path)
    bench.becomes("pegs.length", 4)
    assert bench.board == board
    path.write_text('{"pegs": 3}')
    bench.page.locator("#file").set_input_files(path)
    expect(bench.page.locator("#keep-text")).to_contain_text("pegs are not a list")
    path.write_text("{")
    bench.page.locator("#file").set_input_files(path)
    expect(bench.page.locator("#keep-text")).to_contain_text("not JSON")
    assert bench.board == board


def test_a_board_is_registered_and_played_in_a_room(bench: Bench) -> None:
    board = Board.from_json(bench.board)
    bench.page.get_by_role("button", name="Register").click()
    expect(bench.page.locator("#keep-text")).to_contain_text(board.digest)
    assert bench.screen.api(f"boards/{board.digest}")["name"] == board.name
    bench.page.get_by_role("button", name="Play it in a room").click()
    bench.page.wait_for_url(re.compile(r"\?room="))
    screen = bench.screen.ready()
    screen.seed.fill("42")
    screen.drop.click()
    screen.landed(screen.api(f"drops/{board.digest}/42")["bin"])


def test_payouts_from_too_few_drops_are_solved_with_a_warning(opened: Open) -> None:
    bench = Bench(opened("/editor.html?board=triangle-16"))
    bench.page.get_by_role("button", name="Solve payouts").click()
    result = bench.page.locator("#result")
    expect(result).to_contain_text("Payouts solved from")
    expect(result).to_contain_text("to be sure of their multipliers: 0, ")


def test_any_preset_is_a_start(bench: Bench) -> None:
    bench.page.get_by_label("Start from").select_option("classic")
    bench.becomes("name", "classic")
    bench.checked("good")
    assert Board.from_json(bench.board) == Board.preset("classic")


def test_a_board_named_in_the_address_is_opened(opened: Open) -> None:
    bench = Bench(opened("/editor.html?board=triangle-8"))
    assert Board.from_json(bench.board) == Board.preset("triangle-8")
    bench.tool("Move")
    peg = bench.board["pegs"][10]
    bench.page.get_by_label("Snap to").select_option("0")
    bench.drag([peg["x"], peg["y"]], [peg["x"] + 0.07, peg["y"] + 0.02])
    bench.until("Math.abs(board.pegs[10].x - arg) < 0.02", peg["x"] + 0.07)


def test_a_truncated_link_is_reported(opened: Open) -> None:
    screen = opened("/editor.html#board=abc").state("failed")
    expect(screen.result).to_contain_text("cannot be read")


# Starts the test drops, and cancels them when some are counted. Returns the button's text before,
# and whether the progress was shown.
_CANCEL = """() => new Promise((told) => {
  const test = document.querySelector("#test");
  const counted = new MutationObserver(() => {
    counted.disconnect();
    told([test.textContent, document.querySelector("progress").checkVisibility()]);
    test.click();
  });
  counted.observe(document.querySelector("#tray-count"), { childList: true });
  test.click();
})"""


def test_test_drops_ask_no_server_and_can_be_cancelled(bench: Bench) -> None:
    asked: list[str] = []
    bench.page.on("request", lambda request: asked.append(request.url))
    bench.page.locator("#test-count").select_option("100000")
    test = bench.page.locator("#test")
    # Within the page: on a busy machine all drops would be counted before a click from here.
    assert bench.page.evaluate(_CANCEL) == ["Cancel", True]
    expect(bench.screen.result).to_contain_text("Cancelled.")
    expect(test).to_have_text("Test-drop")
    expect(bench.page.get_by_role("progressbar")).to_be_hidden()
    assert not [url for url in asked if "/api/" in url]


@pytest.mark.long
@pytest.mark.parametrize("device", SCREENS)
def test_the_editor_fits_its_screens(opened: Open, device: str) -> None:
    options = context_for(device)
    bench = Bench(opened("/editor.html?board=triangle-8", **options))
    bench.page.get_by_role("button", name="Test-drop").click()
    expect(bench.page.locator("#tray-count")).to_have_text("100 test balls")
    bench.field.focus()
    bench.press("PageDown", "PageDown")
    for name in each_screen(bench.screen, device):
        check_fit(bench.screen)
        check_axe_on(bench.screen, name)
        bench.screen.shot(f"editor-{name}")


def test_a_finger_moves_a_peg_that_it_touches_and_nothing_else(opened: Open) -> None:
    bench = Bench(opened("/editor.html", **context_for("phone")))
    bench.tool("Move")
    pegs = bench.board["pegs"]
    session = bench.page.context.new_cdp_session(bench.page)
    box = bench.field.bounding_box()
    assert box is not None

    def pull(x: float, y: float, by: float) -> None:
        """Swipe upwards with one finger from a place on the board."""
        ((left, top),) = bench.places([x, y])
        at = {"x": box["x"] + left, "y": box["y"] + top}
        session.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [at]})
        for step in range(1, 9):
            moved = {**at, "y": at["y"] - by * step / 8}
            session.send("Input.dispatchTouchEvent", {"type": "touchMove", "touchPoints": [moved]})
        session.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})

    (_, top), (_, bottom) = bench.places([0.0, 0.0], [0.0, 1.0])
    pull(pegs[0]["x"], pegs[0]["y"], 0.3 * (bottom - top))
    bench.until("board.pegs[0].y < arg - 0.2", pegs[0]["y"])
    assert bench.page.evaluate("scrollY") == 0
    board = bench.board
    pull(0.0, 1.9, 120)
    # The page does not scroll; the desk scrolls within it.
    assert bench.page.evaluate("document.documentElement.scrollHeight <= innerHeight")
    assert bench.board == board


def test_on_a_phone_the_board_is_large_and_its_knobs_cover_no_multiplier(opened: Open) -> None:
    bench = Bench(opened("/editor.html?board=triangle-8", **context_for("phone")))
    expect(bench.page.get_by_text("With Move you drag pegs")).to_be_visible()
    expect(bench.page.locator("#field-help")).to_be_hidden()
    field = bench.field.bounding_box()
    assert field is not None
    assert field["width"] >= 0.7 * 360
    bins = bench.board["bins"]
    lit = """
    ([x, from, to]) => {
      const canvas = document.getElementById("field");
      const density = canvas.width / canvas.clientWidth;
      const box = [x - 3, from, 6, to - from].map((each) => Math.round(each * density));
      const { data } = canvas.getContext("2d").getImageData(...box);
      return data.filter((alpha, i) => i % 4 === 3 && alpha > 200).length;
    }
    """
    middle = bins["edges"][4]
    ((x, y),) = bench.places([middle, bins["y"]])
    height = field["height"]
    assert bench.page.evaluate(lit, [x, y + 3, height - 22]) == 0, "nothing between the multipliers"
    assert bench.page.evaluate(lit, [x, height - 22, height]) > 20, "a knob below them"


def test_a_finger_places_and_moves_a_peg(opened: Open) -> None:
    bench = Bench(opened("/editor.html", **context_for("phone")))
    count = len(bench.board["pegs"])
    bench.tool("Peg")
    ((x, y),) = bench.places([0.0, 2.0])
    bench.field.tap(position={"x": x, "y": y})
    bench.becomes("pegs.length", count + 1)
    bench.becomes("pegs.at(-1).y", 2)
