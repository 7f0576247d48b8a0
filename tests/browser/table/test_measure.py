"""The instruments show true values."""

import json
import math
import re
import urllib.request
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import expect

from plinko.engine import Board
from plinko.engine.payouts.record import odds_of_record
from tests.browser.conftest import Open, Quick, Run
from tests.browser.screen import COUNT_FRAMES


def measuring(screen: Any) -> Any:
    """Open the instruments of a page; returns its screen."""
    screen.drawer("For the curious").locator("#measure summary").click()
    expect(screen.page.get_by_role("heading", name="One ball")).to_be_visible()
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


def test_one_ball_is_followed_and_its_speed_and_energy_drawn(opened: Open) -> None:
    screen = measuring(opened("/?room=triangle-16", before=COUNT_FRAMES).ready())
    screen.seed.fill("42")
    screen.drop.click()
    expect(screen.page.locator("#ball-note")).to_have_text("Following seed 42.")
    speed = screen.page.locator("#speed-plot")
    expect(speed).to_have_attribute("aria-label", re.compile(r"now [\d.]+ m/s, at most [\d.]+"))
    screen.landed(screen.api("drops/triangle-16/42")["bin"])
    screen.ready().at_rest()
    board = screen.api("boards/triangle-16")["board"]
    frames = screen.api("drops/triangle-16/42/frames?fps=60")
    at = {name: index for index, name in enumerate(frames["fields"])}
    # The ball is fastest immediately before an impact.
    states = frames["frames"] + frames["before"]
    speeds = [math.hypot(row[at["vx"]], row[at["vy"]]) for row in states]
    said = re.search(r"at most ([\d.]+[\d])", speed.get_attribute("aria-label") or "")
    assert said
    assert float(said[1]) == pytest.approx(max(speeds), rel=0.01)
    energy = screen.page.locator("#energy-plot").get_attribute("aria-label") or ""
    found = re.search(r"time: ([\d.]+) (k?)J at first, now (\d+\.?\d*\d)", energy)
    assert found, energy
    mass = board["ball"]["density"] * math.pi * board["ball"]["radius"] ** 2
    first = mass * board["gravity"] * (board["bins"]["y"] - board["drop"]["y"])
    unit = 1000 if found[2] else 1
    assert float(found[1]) * unit == pytest.approx(first, rel=0.02)
    assert float(found[3]) < 0.6 * float(found[1]), "bounces and air have taken most of it"
    screen.shot("one-ball")


def test_a_ball_is_chosen_by_a_click_on_it(opened: Open) -> None:
    screen = measuring(
        opened("/?room=triangle-16", viewport={"width": 1400, "height": 800}).ready()
    )
    other = opened("/?room=triangle-16").ready()
    other.seed.fill("77")
    other.drop.click()
    screen.state("live")
    expect(screen.page.locator("#ball-note")).to_contain_text("Click a ball")
    # Found and clicked within one frame: on a busy machine the ball would move on.
    screen.page.wait_for_function(_CLICK_SILVER)
    expect(screen.page.locator("#ball-note")).to_have_text("Following seed 77.")


# Click in the middle of another player's ball, whose pixels are light and nearly grey. Returns true
# if there was one, below the area where a click drops a ball.
_CLICK_SILVER = """() => {
  const canvas = document.querySelector("#board-moving");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let count = 0, x = 0, y = 0;
  for (let i = 0; i < data.length; i += 4) {
    if (data[i + 3] < 250 || data[i] < 170 || Math.abs(data[i] - data[i + 2]) > 25) continue;
    x += (i / 4) % canvas.width;
    y += Math.floor(i / 4 / canvas.width);
    count += 1;
  }
  const density = canvas.width / canvas.clientWidth;
  if (count <= 8 || y / count / density < 160) return false;
  const box = canvas.getBoundingClientRect();
  canvas.dispatchEvent(new MouseEvent("click", {
    bubbles: true,
    clientX: box.left + x / count / density,
    clientY: box.top + y / count / density,
  }));
  return true;
}"""


def test_closed_instruments_ask_the_server_for_nothing(opened: Open) -> None:
    screen = opened("/?room=triangle-10", viewport={"width": 800, "height": 700}).ready()
    expect(screen.page.locator("#measure")).not_to_have_attribute("open", "")
    screen.drop.click()
    expect(screen.rows).to_have_count(1)
    screen.ready()
    asked = {json.loads(frame)["type"] for frame in screen.sent}
    assert asked <= {"appear", "session", "open", "drop"}
    assert len(screen.drops_sent) == 1
