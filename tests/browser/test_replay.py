"""The replay of a drop: by link, at any moment and speed, impact by impact, verified."""

import math
import re
from collections.abc import Iterator

import httpx
import pytest
from playwright.sync_api import Route, expect

from plinko.engine import Board, drop
from tests.browser.access.axe import check_axe_on
from tests.browser.conftest import ARTIFACTS, Complaints, Open, Profiles, Quick, Run
from tests.browser.looks import SCREENS, check_fit, context_for, each_screen, painted
from tests.browser.screen import Screen
from tests.kit.address import Address
from tests.kit.waiting import LIMIT

LINK = "/replay.html?board=triangle-8&seed=42"


def moment(screen: Screen) -> float:
    """The replay's time in s, as the page shows it."""
    return float(screen.page.locator("#time").input_value())


@pytest.fixture(scope="module")
def kept(profiles: Profiles, server: Address) -> Iterator[Screen]:
    """One page for all tests of this drop that change only the replay's time."""
    page = profiles.of({}).new_page(server.url)
    screen = Screen(page, server.url, ARTIFACTS)
    page.goto(f"{server.url}{LINK}")
    yield screen.state("replay").curious()
    page.close()


@pytest.fixture
def replay(kept: Screen, complaints: Complaints) -> Iterator[Screen]:
    """The shared page, paused at the start of the drop."""
    complaints.watch(kept.page)
    kept.paused()
    yield kept
    complaints.leave(kept.page)


def test_a_replay_link_shows_the_same_bin_and_digest_as_live(opened: Open, quick: Quick) -> None:
    screen = opened(quick.page).ready()
    screen.seed.fill("18446744073709551615")
    screen.drop.click()
    record = screen.api(f"drops/{quick.board}/18446744073709551615")
    screen.landed(record["bin"])
    screen.drawer("Game")
    screen.rows.first.get_by_role("link").click()

    screen.state("replay")
    screen.landed(record["bin"])
    expect(screen.fact("seed")).to_have_text("18446744073709551615")
    expect(screen.fact("bin")).to_have_text(str(record["bin"]))
    expect(screen.fact("digest")).to_have_text(record["digest"])

    screen.page.reload()
    screen.landed(record["bin"])
    expect(screen.fact("digest")).to_have_text(record["digest"])
    screen.page.get_by_role("link", name="Back to the table").click()
    screen.ready()
    expect(screen.rows).to_have_count(1)


def test_a_link_of_the_first_release_still_leads_to_the_replay(opened: Open) -> None:
    screen = opened("/?board=triangle-8&seed=7&x=0.125").state("replay")
    record = screen.api("drops/triangle-8/7?x=0.125")
    expect(screen.fact("digest")).to_have_text(record["digest"])
    expect(screen.fact("start")).to_have_text("0.125 m, practice")


def test_any_moment_can_be_shown_and_is_always_the_same_picture(replay: Screen) -> None:
    sampled = replay.api("drops/triangle-8/42/frames?fps=1")
    board = replay.api("boards/triangle-8")["board"]
    time = replay.page.get_by_label("Time of the fall")
    at = []
    for when in ("1", "2", "1"):
        time.fill(when)
        expect(replay.page.locator("#clock")).to_have_text(f"{when}.000 s")
        at.append(replay.ball())
    drawn = replay.pixels(board, [sampled["frames"][i][1:3] for i in (1, 2)])
    radius = board["ball"]["radius"] * drawn["scale"]
    assert math.dist(at[0], drawn["points"][0]) < 0.5 * radius
    assert math.dist(at[1], drawn["points"][1]) < 0.5 * radius
    assert at[0] == at[2], "the same moment is the same picture"


def test_each_impact_is_listed_with_its_time_normal_and_impulse(replay: Screen) -> None:
    record = replay.api("drops/triangle-8/42")
    board = Board.preset("triangle-8")
    rows = replay.page.locator("#impacts tr")
    expect(rows).to_have_count(len(record["impacts"]))
    before = replay.api("drops/triangle-8/42/frames?fps=1")["before"]
    number = 2
    t, x, y, vx, vy, omega, kind, index = record["impacts"][number]
    assert kind == 0, "the third impact of this drop is on a peg"
    rows.nth(number).click()
    expect(replay.page.locator("#clock")).to_have_text(f"{t:.3f} s")
    assert moment(replay) == pytest.approx(t, abs=1e-9)
    expect(replay.fact("impact")).to_have_text(
        f"{number + 1} of {len(record['impacts'])}: peg {index}"
    )
    expect(replay.fact("time")).to_have_text(f"{t!r} s")

    peg = board.pegs[index]
    angle = math.degrees(math.atan2(peg.y - y, x - peg.x))
    expect(replay.fact("normal")).to_contain_text(f"{angle:.0f}°".replace("-", "−"))
    impulse = board.ball.mass * math.hypot(vx - before[number][4], vy - before[number][5])
    expect(rows.nth(number).locator("td").nth(4)).to_have_text(f"{impulse:.4g}")
    expect(replay.fact("spin")).to_contain_text(f"{omega:.4g} rad/s".replace("-", "−"))
    expect(replay.result).to_contain_text(f"Impact {number + 1}, peg {index}")
    assert painted(replay, "board-arrows") > 200, "its normal and impulse are drawn"
    replay.shot("replay-impact")

    replay.page.get_by_label("Time of the fall").fill("0.1")
    expect(replay.fact("chosen")).to_contain_text("none")
    assert painted(replay, "board-arrows") == 0


def test_the_record_says_how_sure_the_bin_is(replay: Screen) -> None:
    record = replay.api("drops/triangle-8/42?certainty=true")
    expect(replay.fact("certain")).to_contain_text("yes" if record["certain"] else "no")
    told = replay.fact("chaotic").text_content() or ""
    digits, power = re.search(r"([\d.]+)(?:·10(\S+))? times", told).groups()  # type: ignore[union-attr]
    ten = 10 ** int((power or "⁰").translate(str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")))
    assert float(digits) * ten == pytest.approx(record["amplification"], rel=0.01)


def test_the_close_up_shows_the_ball_and_keeps_out_of_its_way(opened: Open) -> None:
    screen = opened(LINK).paused().curious()
    time = screen.page.get_by_label("Time of the fall")
    loupe = screen.page.locator("#closeup")
    duration = screen.api("drops/triangle-8/42")["duration"]
    for step in range(12):
        time.fill(str(step / 11 * duration))
        screen.page.evaluate("new Promise(requestAnimationFrame)")
        lens, board = loupe.bounding_box(), screen.page.locator("#board").bounding_box()
        assert lens is not None
        assert board is not None
        if step < 11:  # at the end the ball has gone into its bin
            x, y = screen.ball()
            dx = board["x"] + x - lens["x"] - lens["width"] / 2
            dy = board["y"] + y - lens["y"] - lens["height"] / 2
            assert math.hypot(dx, dy) > lens["width"] / 2
        assert painted(screen, "closeup") > 1000
    screen.page.get_by_label(re.compile("Close-up")).uncheck()
    expect(loupe).to_be_hidden()


def test_time_goes_by_frames_and_by_impacts_with_keys_alone(opened: Open) -> None:
    screen = opened(LINK).state("replay").curious()
    page = screen.page
    record = screen.api("drops/triangle-8/42")
    times = [impact[0] for impact in record["impacts"]]
    page.keyboard.press("Space")
    expect(page.get_by_role("button", name="Play", exact=True)).to_be_visible()
    page.keyboard.press("Home")
    assert moment(screen) == 0
    page.keyboard.press("ArrowRight")
    assert moment(screen) == pytest.approx(1 / 60)
    for number in (0, 1, 2):
        page.keyboard.press("Shift+ArrowRight")
        assert moment(screen) == pytest.approx(times[number], abs=1e-9)
        expect(screen.fact("impact")).to_contain_text(f"{number + 1} of {len(times)}")
    page.keyboard.press("Shift+ArrowLeft")
    assert moment(screen) == pytest.approx(times[1], abs=1e-9)
    page.get_by_role("radio", name="1/100").focus()
    page.keyboard.press("Space")
    page.get_by_role("button", name="One frame on").focus()
    page.keyboard.press("Enter")
    assert moment(screen) == pytest.approx(times[1] + 1 / 6000)
    page.keyboard.press("End")
    assert moment(screen) == pytest.approx(record["duration"], abs=1e-9)


def test_slow_motion_is_as_slow_as_it_says(replay: Screen) -> None:
    replay.page.get_by_role("radio", name="1/100").check()
    replay.page.get_by_label("Time of the fall").fill("0.5")
    before, after = replay.page.evaluate(
        """async () => {
          const time = document.querySelector("#time");
          const seen = []; // the display's time and the replay's, after each frame of the page
          const next = window.requestAnimationFrame;
          window.requestAnimationFrame = (draw) => next((now) => {
            draw(now);
            seen.push([now, Number(time.value)]);
          });
          document.querySelector("#play").click();
          while (seen.length < 3 || seen.at(-1)[0] - seen[1][0] < 700) await new Promise(next);
          window.requestAnimationFrame = next;
          return [seen[1], seen.at(-1)];
        }"""
    )
    speed = 1000.0 * (after[1] - before[1]) / (after[0] - before[0])
    assert speed == pytest.approx(0.01, rel=0.01)


def test_the_server_reproduces_the_digest(replay: Screen) -> None:
    replay.page.get_by_role("button", name="Verify").click()
    verdict = replay.page.locator("#verdict")
    expect(verdict).to_contain_text("Reproduced")
    expect(verdict).to_contain_text(replay.api("drops/triangle-8/42")["digest"])


def test_a_record_that_was_tampered_with_is_not_reproduced(opened: Open) -> None:
    def tamper(route: Route) -> None:
        response = route.fetch()
        record = response.json()
        route.fulfill(response=response, json={**record, "x_end": record["x_end"] + 1e-12})

    screen = opened("about:blank")
    screen.page.route(re.compile(r"/drops/triangle-8/42(\?|$)"), tamper)
    screen.page.goto(f"{screen.url}{LINK}")
    screen.paused().curious()
    screen.page.get_by_role("button", name="Verify").click()
    expect(screen.page.locator("#verdict")).to_contain_text("Not reproduced: x_end")


def test_the_energy_is_shown_and_a_click_seeks_its_moment(replay: Screen) -> None:
    plot = replay.page.get_by_role("img", name=re.compile("Energy of the ball.*percent lost"))
    box = plot.bounding_box()
    assert box is not None
    plot.click(position={"x": box["width"] / 2, "y": box["height"] / 2})
    duration = replay.api("drops/triangle-8/42")["duration"]
    assert 0.3 * duration < moment(replay) < 0.7 * duration
    bare = painted(replay, "energy")
    replay.page.get_by_label("with height").check()
    replay.page.wait_for_function(
        f"""() => {{
          const canvas = document.querySelector("#energy");
          const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
          return data.filter((_, i) => i % 4 === 3).filter(Boolean).length !== {bare};
        }}"""
    )


def test_the_table_can_be_kept_as_a_file(replay: Screen) -> None:
    with replay.page.expect_download() as download:
        replay.page.get_by_role("button", name="Save as CSV").click()
    lines = download.value.path().read_text().splitlines()
    record = replay.api("drops/triangle-8/42")
    assert len(lines) == 1 + len(record["impacts"])
    names = lines[0].split(",")
    first = dict(zip(names, lines[1].split(","), strict=True))
    assert float(first["t"]) == record["impacts"][0][0]
    assert float(first["vx_after"]) == record["impacts"][0][3]


def test_reduced_motion_shows_the_whole_path_at_once(opened: Open) -> None:
    screen = opened(LINK, reduced_motion="reduce").state("replay").curious()
    expect(screen.page.get_by_role("button", name="Play", exact=True)).to_be_visible()
    duration = screen.api("drops/triangle-8/42")["duration"]
    assert moment(screen) == pytest.approx(duration, abs=1e-9)
    screen.until(lambda: painted(screen, "board-marks") > 500)


def test_a_board_travels_in_the_link_itself(opened: Open, run: Run) -> None:
    board = {**Board.preset("triangle-8").to_dict(), "name": "carried", "gravity": 20.0}
    packed = run("net/board-link.js", "({ packBoard }, board) => packBoard(board)", board)
    screen = opened(f"/replay.html?seed=5#board={packed}").state("replay").curious()
    done = drop(Board.from_json(board), 5)
    expect(screen.fact("board")).to_have_text("carried")
    expect(screen.fact("digest")).to_have_text(done.digest)
    screen.page.goto(f"{screen.url}/replay.html?seed=5#board=nonsense")
    screen.state("failed")
    expect(screen.result).to_contain_text("cannot be read")


def test_the_board_of_a_drop_is_chosen_before_the_list_of_boards_comes(opened: Open) -> None:
    screen = opened("about:blank")
    screen.page.route("**/api/v1/boards", lambda _: None)  # it never comes
    screen.page.goto(f"{screen.url}{LINK}")
    screen.state("replay")
    expect(screen.page.locator("#other-board")).to_have_value("triangle-8")


def test_the_stepped_solver_is_replayed_as_it_stepped(opened: Open) -> None:
    screen = opened(LINK).state("replay").curious()
    screen.page.get_by_role("radio", name="Stepped").check()
    screen.page.get_by_label("Seed", exact=True).fill("43")
    screen.page.get_by_role("button", name="Replay it").click()
    screen.page.wait_for_url(re.compile("solver=stepped"))
    screen.state("replay")
    record = screen.api("drops/triangle-8/43?solver=stepped")
    expect(screen.fact("digest")).to_have_text(record["digest"])
    expect(screen.fact("solver")).to_contain_text("stepped")


def test_a_bad_seed_is_named_next_to_its_field(replay: Screen) -> None:
    field = replay.page.get_by_label("Seed", exact=True)
    field.fill("-3")
    replay.page.get_by_role("button", name="Replay it").click()
    expect(replay.page.locator("#other-note")).to_contain_text("-3")
    expect(field).to_be_focused()
    expect(field).to_have_attribute("aria-invalid", "true")


@pytest.mark.parametrize(
    ("query", "named"),
    [("board=nonagon&seed=1", "nonagon"), ("board=triangle-8&seed=x1", "x1"),
     ("board=triangle-8&seed=1&x=99", "99")],
)  # fmt: skip
def test_an_impossible_drop_is_reported(
    opened: Open, complaints: Complaints, query: str, named: str
) -> None:
    screen = opened(f"/replay.html?{query}").state("failed")
    expect(screen.result).to_contain_text(named)
    complaints.allow("404|422")


@pytest.mark.long
@pytest.mark.parametrize("device", SCREENS)
def test_the_replay_fits_its_screens(opened: Open, device: str) -> None:
    options = context_for(device)
    screen = opened(LINK, **options).state("replay").curious()
    play = screen.page.locator("#play")
    play.click()
    screen.page.locator("#impacts tr").nth(3).click()
    for name in each_screen(screen, device):
        check_fit(screen)
        check_axe_on(screen, name)
        screen.shot(f"replay-{name}")


def test_a_drop_that_rides_pegs_is_shown_to_its_end(opened: Open, server: Address) -> None:
    """Balls that hardly bounce roll over pegs: the list of impacts says so."""
    dead = {"restitution": 0.1, "friction": 0.4}
    board = {**Board.preset("triangle-8").to_dict(), "name": "dead", "peg_material": dead}
    board["ball"] = {**board["ball"], **dead}
    digest = httpx.post(f"{server.url}/api/v1/boards", json=board, timeout=LIMIT).json()["digest"]
    screen = opened(f"/replay.html?board={digest}&seed=3").state("replay").curious()
    record = screen.api(f"drops/{digest}/3")
    assert 2 in [impact[6] for impact in record["impacts"]]
    expect(screen.page.locator("#impacts")).to_contain_text("rides peg")
    expect(screen.page.locator("#impacts")).to_contain_text("leaves peg")
    screen.page.keyboard.press("End")
    expect(screen.fact("digest")).to_have_text(record["digest"])
    screen.shot("replay-rides")


def test_a_ball_that_never_settles_is_replayed_to_where_it_ends(
    opened: Open, server: Address
) -> None:
    """A ball in perfect balance on a peg lands in no bin, and stays visible."""
    board = {
        "name": "balance",
        "pegs": [{"x": 0.0, "y": 1.0, "radius": 0.05}],
        "width": 3.0,
        "height": 2.0,
        "bins": {"y": 2.0, "edges": [-1.5, 0.0, 1.5], "multipliers": [1.0, 2.0]},
    }
    posted = httpx.post(f"{server.url}/api/v1/boards", json=board, timeout=LIMIT).json()
    screen = opened(f"/replay.html?board={posted['digest']}&seed=1").state("replay").curious()
    record = screen.api(f"drops/{posted['digest']}/1")
    assert record["bin"] is None
    expect(screen.root).to_have_attribute("data-last-bin", "none")
    expect(screen.result).to_contain_text("comes to rest outside the bins")
    screen.page.keyboard.press("End")
    ((x, y),) = screen.pixels(
        posted["board"], [[0.0, 1.0 - 0.05 - posted["board"]["ball"]["radius"]]]
    )["points"]
    assert math.dist(screen.ball(), (x, y)) < 6


def test_the_pages_lead_to_each_other(opened: Open) -> None:
    screen = opened().ready()
    for name, state in (
        ("Editor", "asleep"),
        ("Replay", "replay"),
        ("Editor", "asleep"),
        ("Play", "asleep"),
    ):
        nav = screen.page.get_by_role("navigation", name="Pages")
        nav.get_by_role("link", name=name, exact=True).click()
        here = nav.get_by_role("link", name=name, exact=True)
        expect(here).to_have_attribute("aria-current", "page")
        screen.state(state)
        if name == "Replay":  # whose door leads to a comparison
            screen.page.locator("#curious > summary").click()
            screen.page.get_by_role("button", name="Compare", exact=True).click()
            screen.page.wait_for_url(re.compile("&compare"))
            screen.state("replay")
            expect(here).to_have_attribute("aria-current", "page")
