"""Two drops side by side: starts one bit apart, other seeds, distance and separation."""

import math
import re

import numpy as np
import pytest
from playwright.sync_api import expect

from plinko.engine import Board, Drop, drop
from tests.browser.access.axe import check_axe_on
from tests.browser.conftest import Complaints, Open
from tests.browser.looks import SCREENS, check_fit, context_for, each_screen, painted
from tests.browser.screen import Screen

LINK = "/replay.html?board=triangle-12&seed=42&compare"


def parted(one: Drop, two: Drop) -> float | None:
    """The first time in s when two balls are more than a radius apart, in steps of 1 ms."""
    times = np.arange(0.0, min(one.duration, two.duration), 1e-3)
    a, b = one.states(times), two.states(times)
    apart = np.hypot(a["x"] - b["x"], a["y"] - b["y"])
    (far,) = np.nonzero(apart > one.board.ball.radius)
    return float(times[far[0]]) if len(far) else None


def check_verdict(screen: Screen, one: Drop, two: Drop) -> None:
    when = parted(one, two)
    if when is None:
        expect(screen.result).to_contain_text("stay within a ball's radius")
        return
    expect(screen.result).to_contain_text("They separate after impact")
    text = screen.result.text_content() or ""
    found = re.search(r"after impact (\d+) \(([\d.]+) s\)", text)
    assert found
    assert float(found[2]) == pytest.approx(when, abs=0.01)
    hits = [impact["t"] for impact in one.impacts if impact["kind"] in (0, 1)]
    assert int(found[1]) in {sum(t <= at for t in hits) for at in (when - 1e-3, when)}


def test_the_second_ball_starts_one_bit_from_the_first(opened: Open) -> None:
    screen = opened(LINK).paused()
    board = Board.preset("triangle-12")
    one = drop(board, 42)
    two = drop(board, 42, x=math.nextafter(one.x_start, math.inf))
    expect(screen.fact("start-1")).to_have_text(f"{one.x_start!r} m")
    expect(screen.fact("start-2")).to_have_text(f"{two.x_start!r} m")
    expect(screen.fact("digest-2")).to_have_text(f"{two.digest[:12]}…")
    expect(screen.fact("bin-2")).to_have_text(str(two.bin))
    check_verdict(screen, one, two)
    expect(
        screen.page.get_by_role("img", name=re.compile("Distance of the two.*apart"))
    ).to_have_count(1)


@pytest.mark.parametrize(("name", "shift"), [("1 nm", 1e-9), ("1 mm", 1e-3)])
def test_a_difference_can_be_chosen(opened: Open, name: str, shift: float) -> None:
    screen = opened(LINK).paused()
    screen.page.get_by_role("radio", name=name).check()
    screen.page.get_by_role("button", name="Compare", exact=True).click()
    screen.page.wait_for_url(re.compile("shift="))
    screen.state("replay")
    board = Board.preset("triangle-12")
    one = drop(board, 42)
    check_verdict(screen, one, drop(board, 42, x=one.x_start + shift))


def test_two_seeds_are_compared_with_their_distance_at_all_times(opened: Open) -> None:
    screen = opened(LINK).paused()
    page = screen.page
    page.get_by_role("radio", name="other seed").check()
    page.get_by_label("Second seed").fill("7")
    page.get_by_role("button", name="Compare", exact=True).click()
    page.wait_for_url(re.compile("with=7"))
    screen.paused()
    board = Board.preset("triangle-12")
    one, two = drop(board, 42), drop(board, 7)
    page.get_by_label("Time of the fall").fill("1.5")
    (a,), (b,) = one.states([1.5]), two.states([1.5])
    apart = math.dist((a["x"], a["y"]), (b["x"], b["y"]))
    expect(page.locator("#now")).to_have_text(f"{float(f'{apart:.4g}'):g} m")
    assert painted(screen, "board-marks") > 500
    screen.shot("compare-seeds")


def test_the_plot_goes_by_time_or_by_impacts_and_leads_there(opened: Open) -> None:
    screen = opened(f"{LINK}&shift=1e-6").paused()
    plot = screen.page.locator("#distance")
    by_time = plot.evaluate("canvas => canvas.toDataURL()")
    screen.page.get_by_label("impacts", exact=True).check()
    assert plot.evaluate("canvas => canvas.toDataURL()") != by_time
    box = plot.bounding_box()
    assert box is not None
    plot.click(position={"x": box["width"] - 30, "y": 40})
    hits = [float(i["t"]) for i in drop(Board.preset("triangle-12"), 42).impacts if i["kind"] < 2]
    at = float(screen.page.locator("#time").input_value())
    assert min(abs(at - t) for t in hits) < 1e-9, "at one of the impacts"


def test_a_start_at_the_edge_is_shifted_inwards(opened: Open) -> None:
    zone = Board.preset("triangle-12").drop
    edge = zone.x + zone.span
    screen = opened(f"{LINK}&x={edge!r}").paused()
    inside = math.nextafter(edge, -math.inf)
    expect(screen.fact("start-2")).to_have_text(f"{inside!r} m")


def test_a_seed_that_is_none_is_named(opened: Open) -> None:
    screen = opened(LINK).paused()
    screen.page.get_by_role("radio", name="other seed").check()
    screen.page.get_by_label("Second seed").fill("x7")
    screen.page.get_by_role("button", name="Compare", exact=True).click()
    expect(screen.page.get_by_role("alert")).to_contain_text("x7")
    expect(screen.page.get_by_label("Second seed")).to_be_focused()


def test_an_unknown_board_is_reported(opened: Open, complaints: Complaints) -> None:
    screen = opened("/replay.html?board=nonagon&compare").state("failed")
    expect(screen.result).to_contain_text("nonagon")
    complaints.allow("404")


def test_reduced_motion_shows_both_paths_at_once(opened: Open) -> None:
    screen = opened(LINK, reduced_motion="reduce").state("replay")
    expect(screen.page.get_by_role("button", name="Play", exact=True)).to_be_visible()
    expect(screen.page.locator("#now")).to_have_text("one has landed")
    screen.until(lambda: painted(screen, "board-marks") > 500)


@pytest.mark.long
@pytest.mark.parametrize("device", SCREENS)
def test_the_comparison_fits_its_screens(opened: Open, device: str) -> None:
    options = context_for(device)
    screen = opened(f"{LINK}&shift=1e-3", **options).paused()
    screen.page.get_by_label("Time of the fall").fill("4")
    for name in each_screen(screen, device):
        check_fit(screen)
        check_axe_on(screen, name)
        screen.shot(f"compare-{name}")
