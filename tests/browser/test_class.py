"""The class's page: a lesson on one screen, by its link, and with thirty phones."""

import json
import re
import signal
from contextlib import ExitStack
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import httpx
import pytest
from playwright.sync_api import Page, Route, expect
from websockets.sync.client import connect

from tests.app.web.test_invitations import read
from tests.browser.access.axe import check_axe, check_axe_on
from tests.browser.conftest import Complaints, Open
from tests.browser.looks import check_fit, context_for, each_screen
from tests.browser.screen import Screen
from tests.browser.table.test_reconnect import GONE
from tests.kit.process import ServerProcess
from tests.kit.waiting import LIMIT

LESSON = "/class.html#rows=8&p=0.5&runs=5x200_900x100"
PHONES = 30


def lesson(opened: Open, path: str = LESSON, **options: str) -> Screen:
    """A lesson whose balls land at once."""
    return opened(path, reduced_motion="reduce", **options).state("live")


def with_phones(opened: Open, url: str) -> tuple[Page, str]:
    """The page of a lesson with a room for phones, and the REST address of the room's drops."""
    page = lesson(opened, f"{url}/class.html#rows=8&p=0.5").page
    page.get_by_text("Link, table, phones").click()
    page.get_by_role("button", name="Invite phones").click()
    expect(page.locator("#here")).to_have_text("0 phones are here")
    link = page.locator("#join-link").get_attribute("href")
    assert link is not None
    (room,) = parse_qs(urlsplit(link).query)["room"]
    return page, f"{url}/api/v1/rooms/{room}/drops?wait=1"


def drop(address: str) -> None:
    httpx.post(address, json={}, timeout=LIMIT).raise_for_status()


def cells(screen: Screen, row: str) -> list[str]:
    """The cells of a row of the numbers' table."""
    name = screen.page.get_by_role("rowheader", name=row, exact=True)
    return screen.page.locator("#numbers tr").filter(has=name).locator("td").all_inner_texts()


def test_a_thousand_balls_follow_theory_and_the_page_says_so(opened: Open) -> None:
    screen = lesson(opened, "/class.html#rows=8&p=0.3&runs=5x1")
    page = screen.page
    page.get_by_role("button", name="A thousand at once").click()
    expect(screen.result).to_have_text("1,001 balls have landed.")
    measured, theory = map(float, cells(screen, "Standard error of the average"))
    assert measured == pytest.approx(theory, rel=0.2)
    mean, ideal = map(float, cells(screen, "Average"))
    assert ideal == 2.4
    assert abs(mean - ideal) < 5 * theory
    expect(page.locator("#surprise")).to_contain_text("by chance alone")
    page.get_by_role("radio", name="Means of samples").check(force=True)
    expect(page.locator("#view-words")).to_contain_text("100 samples of 10 balls")
    expect(page.get_by_role("img", name=re.compile("100 samples"))).to_be_visible()
    page.get_by_role("button", name="Clear").click()
    expect(screen.result).to_have_text("0 balls have landed.")


def test_a_link_restores_the_lesson_with_its_balls(opened: Open) -> None:
    first = lesson(opened)
    first.page.get_by_role("radio", name="Runs", exact=True).check(force=True)
    expect(first.page.locator("#table tr")).to_have_count(2)
    table = first.page.locator("#table").inner_text()
    first.page.get_by_text("Link, table, phones").click()
    first.page.get_by_role("button", name="Copy link").click()
    link = first.page.locator("#link").input_value()
    other = lesson(opened, link)
    expect(other.result).to_have_text("300 balls have landed.")
    assert other.page.locator("#table").inner_text() == table
    other.page.get_by_role("radio", name="This run").check(force=True)
    assert cells(other, "Balls")[0] == "100"
    other.page.get_by_text("Link, table, phones").click()
    with other.page.expect_download() as saved:
        other.page.get_by_role("button", name="Save as CSV").click()
    head, *lines = Path(saved.value.path()).read_text().splitlines()
    assert head == "board,run,ball,seed,right,rows"
    assert len(lines) == 300
    assert lines[-1].startswith("1,2,100,999,")


def test_pupils_draw_the_shape_before_they_see_it(opened: Open) -> None:
    screen = lesson(opened)
    page = screen.page
    page.get_by_text("Questions").click()
    page.get_by_role("button", name="Guess the shape first").click()
    expect(screen.result).to_contain_text("Draw the shape")
    box = page.locator("#trial-0").bounding_box()
    assert box
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + 0.8 * box["height"])
    expect(screen.result).to_have_text(re.compile(r"Bin 4: [3-7]\d"))
    for key in ("ArrowRight", "ArrowUp", "ArrowUp"):
        page.keyboard.press(key)
    expect(screen.result).to_have_text("Bin 5: 10")
    expect(page.locator("#table-box")).to_be_hidden()
    page.get_by_role("button", name="A thousand at once").click()
    expect(screen.result).to_contain_text("in common")
    expect(page.locator("#table-box")).to_be_visible()


def test_two_boards_differ_in_one_thing_and_two_balls_in_a_hair(opened: Open) -> None:
    screen = lesson(opened)
    page = screen.page
    page.get_by_label("Second board").select_option("restitution:0.5")
    expect(page.locator("#name-1")).to_have_text("Bounce 0.5")
    page.get_by_role("button", name="A thousand at once").click()
    expect(page.locator("#numbers td").nth(1)).to_have_text("1,000")
    page.get_by_text("Questions").click()
    page.get_by_label("Distance").select_option("0.1 mm")
    page.get_by_role("button", name="Two balls a hair apart").click()
    expect(screen.result).to_contain_text("They start 0.1 mm apart")


def test_a_late_log_of_the_former_board_is_not_counted(
    opened: Open, mortal: ServerProcess, complaints: Complaints
) -> None:
    complaints.allow(GONE)
    page, drops = with_phones(opened, mortal.url)
    counted = page.locator("#numbers td").first
    drop(drops)
    expect(counted).to_have_text("1")
    held: list[tuple[Route, str]] = []

    def hold_first(route: Route) -> None:
        if held:
            route.continue_()
        else:
            held.append((route, httpx.get(route.request.url, timeout=LIMIT).text))

    page.route("**/log", hold_first)
    mortal.end(signal.SIGKILL)
    with page.expect_request("**/log"):
        mortal.start()
    with page.expect_response(lambda reply: reply.request.method == "PATCH"):
        page.locator("#rows").fill("5")
    drop(drops)
    expect(counted).to_have_text("1")
    (route, log), *_ = held
    with page.expect_response("**/log"):
        route.fulfill(body=log, content_type="application/json")
    drop(drops)
    expect(counted).to_have_text("2")


def test_a_class_whose_log_cannot_be_fetched_goes_on_counting(
    opened: Open, mortal: ServerProcess, complaints: Complaints
) -> None:
    complaints.allow(f"{GONE}|503")
    page, drops = with_phones(opened, mortal.url)
    counted = page.locator("#numbers td").first
    drop(drops)
    expect(counted).to_have_text("1")
    page.route("**/log", lambda route: route.fulfill(status=503))
    mortal.end(signal.SIGKILL)
    with page.expect_response("**/log"):
        mortal.start()
    drop(drops)
    expect(counted).to_have_text("2")


def test_thirty_phones_drop_and_the_projector_has_every_ball(
    opened: Open, mortal: ServerProcess, complaints: Complaints
) -> None:
    complaints.allow(GONE)
    teacher = lesson(opened, f"{mortal.url}/class.html#rows=8&p=0.5")
    teacher.page.get_by_text("Link, table, phones").click()
    teacher.page.get_by_role("button", name="Invite phones").click()
    expect(teacher.page.locator("#here")).to_have_text("0 phones are here")
    code = httpx.get(teacher.page.locator("#join").evaluate("one => one.src"), timeout=LIMIT)
    link = read(code.text)
    assert teacher.page.locator("#join-link").get_attribute("href") == link
    room = parse_qs(urlsplit(link).query)["room"][0]
    pupil = opened(link, reduced_motion="reduce", **context_for("phone")).state("live")
    with ExitStack() as stack:
        address = f"{mortal.url.replace('http', 'ws')}/ws/rooms/{room}?stream=seeds"
        phones = [stack.enter_context(connect(address, max_queue=None)) for _ in range(PHONES - 1)]
        for number, phone in enumerate(phones):
            phone.send(json.dumps({"type": "appear", "who": str(number)}))
        expect(teacher.page.locator("#here")).to_have_text(f"{PHONES} phones are here")
        for phone in phones:
            for _ in range(2):
                phone.send(json.dumps({"type": "drop"}))
        for _ in range(2):
            pupil.drop.click()
        expect(pupil.result).to_contain_text("2 balls")
        expect(teacher.page.locator("#numbers td").first).to_have_text(f"{2 * PHONES}")
        teacher.shot("class-projector")
        pupil.shot("class-phone")
        check_fit(pupil)
        check_axe(pupil)
    counts = teacher.page.locator("#table tr td:nth-child(2)")
    before = counts.all_inner_texts()
    mortal.end(signal.SIGKILL)
    mortal.start()
    expect(teacher.page.locator("#here")).to_have_text(re.compile("phones? (is|are) here"))
    # The server may not have written all landings when it was killed: those balls land again.
    expect(counts).to_have_text(before)
    teacher.page.locator("#rows").fill("5")
    expect(pupil.page.locator("#result")).to_have_text("Drop a ball on the class's board.")
    pupil.drop.click()
    expect(pupil.result).to_contain_text("in 5 rows. 1 ball")
    expect(teacher.page.locator("#numbers td").first).to_have_text("1")


@pytest.mark.parametrize("device", ["phone", "desk"])
def test_the_lesson_fits_its_screens(opened: Open, device: str) -> None:
    screen = opened(f"{LESSON}&change=gravity:1.62", **context_for(device)).state("live")
    for part in ("Questions", "Link, table, phones"):
        screen.page.get_by_text(part).click()
    for view in ("Rows", "Means of samples"):
        screen.page.get_by_role("radio", name=view).check(force=True)
        for name in each_screen(screen, device):
            check_fit(screen)
            check_axe_on(screen, name)
            screen.shot(f"class-{view}-{name}")
