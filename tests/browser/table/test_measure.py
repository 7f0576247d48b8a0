"""The instruments show true values."""

import json
import re
import urllib.request
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import expect

from plinko.engine import Board
from plinko.engine.payouts.record import odds_of_record
from tests.browser.conftest import Open, Quick, Run


def measuring(screen: Any) -> Any:
    """Open the instruments of a page; returns its screen."""
    screen.drawer("For the curious").locator("#measure summary").click()
    expect(screen.page.locator("#returns")).to_be_visible()
    return screen


def simulated(screen: Any, board: str, drops: int) -> list[int]:
    request = urllib.request.Request(
        f"{screen.url}/api/v1/simulate",
        json.dumps({"board": board, "drops": drops}).encode(),
        {"content-type": "application/json"},
    )
    with urllib.request.urlopen(request) as reply:
        histogram: list[int] = json.load(reply)["histogram"]
    return histogram


def test_the_p_value_is_that_of_the_tables_counts(opened: Open, quick: Quick, run: Run) -> None:
    screen = measuring(opened(quick.page).ready())
    expect(screen.page.locator("#fit-note")).to_contain_text("too few to judge")
    expect(screen.page.get_by_role("radio", name="Counted")).to_be_disabled()
    expect(screen.page.locator("#tray-key")).to_have_text("expected share")
    screen.page.get_by_role("radio", name="20 balls").check()
    screen.seed.fill("1000")
    screen.drop.click()
    expect(screen.rows).to_have_count(20)
    expect(screen.page.locator("#fit-note")).to_contain_text("20 balls")
    counts = screen.api(f"rooms/{quick.room}")["stats"]["histogram"]
    p = run("model/statistics.js", "({ sameTest }, all) => sameTest(...all).p",
            [counts, simulated(screen, quick.board, 10_000)])  # fmt: skip
    shown = screen.page.locator("#fit-p").inner_text()
    assert float(shown.removeprefix("p = ")) == pytest.approx(p, abs=0.006)
    screen.shot("measure")


def test_a_triangle_is_compared_with_its_counts_or_measurements(
    opened: Open,
) -> None:
    screen = measuring(opened("/?room=triangle-9").ready())
    note = screen.page.locator("#returns-note")
    own, *_ = odds_of_record(Board.preset("triangle-9"))
    expect(note).to_contain_text(f"counted, {own.drops:,} balls")
    screen.page.get_by_role("radio", name="Measured").check()
    expect(note).to_contain_text("measured, 10,000 balls")
    expect(note).to_contain_text(re.compile(r"Expected.*\d %"))
    screen.page.get_by_role("radio", name="Counted").check()
    expect(note).to_contain_text("counted")


def test_returns_are_the_mean_of_the_scores_with_its_doubt(opened: Open, quick: Quick) -> None:
    screen = measuring(opened(quick.page).ready())
    scores = []
    for seed in (42, 43, 44, 45):
        screen.seed.fill(str(seed))
        screen.drop.click()
        scores.append(screen.api(f"drops/{quick.board}/{seed}")["score"])
    expect(screen.rows).to_have_count(4)
    returns = screen.page.locator("#returns")
    expect(returns).to_contain_text("of 4 balls")
    doubt = 3.182446305 * np.std(scores, ddof=1) / 2
    expect(returns).to_contain_text(f"{100 * np.mean(scores):.1f} %")
    expect(returns).to_contain_text(f"± {100 * doubt:.1f}")


def test_closed_instruments_ask_the_server_for_nothing(opened: Open) -> None:
    screen = opened("/?room=triangle-10", viewport={"width": 800, "height": 700}).ready()
    expect(screen.page.locator("#measure")).not_to_have_attribute("open", "")
    screen.drop.click()
    expect(screen.rows).to_have_count(1)
    screen.ready()
    asked = {json.loads(frame)["type"] for frame in screen.sent}
    assert asked <= {"appear", "session", "open", "drop"}
    assert len(screen.drops_sent) == 1
