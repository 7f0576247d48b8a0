"""The instruments: their mathematics against known values, and what a person reads off them."""

import json
import math
import re
import urllib.request
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import expect

from tests.browser.conftest import Open, Quick, Run

# Chi-square: statistic, degrees of freedom, upper tail. To 12 digits by arbitrary-precision
# arithmetic; those at 0.05 are in every table.
TAILS = [
    (3.841458820694124, 1, 0.05),
    (18.307038053275146, 10, 0.05),
    (26.296227604864236, 16, 0.05),
    (0.5, 1, 0.479500122186953),
    (2.0, 2, math.exp(-1.0)),
    (40.0, 2, math.exp(-20.0)),
    (1.0, 16, 0.999999937803091),
]

# Student's t: degrees of freedom, bound at 95 %.
BOUNDS = [(1, 12.706204736), (2, 4.302652730), (10, 2.228138852), (1000, 1.962339081)]


@pytest.mark.parametrize(("statistic", "freedom", "tail"), TAILS)
def test_chi_square_tails_are_those_of_the_tables(
    run: Run, statistic: float, freedom: int, tail: float
) -> None:
    found = run("model/statistics.js", "({ chiSquareTail }, all) => chiSquareTail(...all)",
                [statistic, freedom])  # fmt: skip
    assert found == pytest.approx(tail, rel=1e-9)


@pytest.mark.parametrize("half", [1, 4, 40])
def test_the_incomplete_gamma_of_whole_numbers_is_a_poisson_sum(run: Run, half: int) -> None:
    for x in (0.1, 1.0, float(half), 2.0 * half, 5.0 * half):
        found = run("model/statistics.js", "({ gammaQ }, all) => gammaQ(...all)", [half, x])
        poisson = sum(math.exp(-x + k * math.log(x) - math.lgamma(k + 1)) for k in range(half))
        assert found == pytest.approx(poisson, rel=1e-9), x


@pytest.mark.parametrize(("freedom", "bound"), BOUNDS)
def test_student_bounds_are_those_of_the_tables(run: Run, freedom: int, bound: float) -> None:
    found = run("model/statistics.js", "({ studentBound }, n) => studentBound(0.95, n)", freedom)
    assert found == pytest.approx(bound, rel=1e-8)


def test_the_gamma_function_is_the_factorial(run: Run) -> None:
    for x in (0.5, 1.0, 2.0, 3.5, 10.0, 171.0, 1e5):
        found = run("model/statistics.js", "({ logGamma }, x) => logGamma(x)", x)
        assert found == pytest.approx(math.lgamma(x), rel=1e-12, abs=1e-12)


def test_a_fit_of_three_bins_by_hand(run: Run) -> None:
    fit = run("model/statistics.js", "({ fitTest }, all) => fitTest(...all)",
              [[30, 20, 10], [1 / 3, 1 / 3, 1 / 3]])  # fmt: skip
    g = 2 * sum(count * math.log(count / 20) for count in (30, 20, 10))
    assert fit["statistic"] == pytest.approx(g)
    assert fit["freedom"] == 2
    assert fit["p"] == pytest.approx(math.exp(-g / 2))


def test_rare_bins_are_judged_together_and_too_few_balls_not_at_all(run: Run) -> None:
    chances = [math.comb(8, k) / 256 for k in range(9)]
    call = "({ fitTest }, all) => fitTest(...all)"
    assert run("model/statistics.js", call, [[0] * 9, chances]) is None
    assert run("model/statistics.js", call, [[0, 0, 0, 1, 2, 1, 0, 0, 0], chances]) is None
    some = run("model/statistics.js", call, [[0, 1, 4, 8, 10, 9, 5, 2, 1], chances])
    assert 3 <= some["groups"] < 9
    many = run("model/statistics.js", call, [[40, 310, 1090, 2190, 2730, 2190, 1100, 310, 40], chances])
    assert many["groups"] == 9


def test_the_tests_cry_wolf_as_often_as_they_say(run: Run) -> None:
    chance = np.random.default_rng(7)
    share = np.array([math.comb(16, k) for k in range(17)]) / 2**16
    samples = chance.multinomial(400, share, size=1500).tolist()
    others = chance.multinomial(2000, share, size=1500).tolist()
    alone, both = run(
        "model/statistics.js",
        """({ fitTest, sameTest }, { samples, others, share }) => [
          samples.map((counts) => fitTest(counts, share).p),
          samples.map((counts, i) => sameTest(counts, others[i]).p),
        ]""",
        {"samples": samples, "others": others, "share": share.tolist()},
    )
    for found in (np.array(alone), np.array(both)):
        assert 0.03 < np.mean(found < 0.05) < 0.075
        assert 0.44 < np.mean(found < 0.5) < 0.56


def test_a_wrong_law_is_found_out(run: Run) -> None:
    share = [math.comb(8, k) / 256 for k in range(9)]
    skewed = [round(1000 * part) for part in [*share[1:], share[0]]]
    assert run("model/statistics.js", "({ fitTest }, all) => fitTest(...all).p", [skewed, share]) < 1e-6


def test_mean_and_doubt_are_those_of_the_textbook(run: Run) -> None:
    values = [0.2, 0.2, 1.0, 4.0, 0.3]
    found = run(
        "model/statistics.js",
        """({ Mean }, values) => {
          const one = new Mean();
          for (const value of values) one.add(value);
          const many = new Mean();
          many.add(0.2, 2); many.add(1); many.add(4); many.add(0.3);
          return [one.mean, one.doubt(0.95), many.mean, many.doubt(0.95)];
        }""",
        values,
    )
    doubt = 2.7764451052 * np.std(values, ddof=1) / math.sqrt(5)
    assert found == pytest.approx([np.mean(values), doubt] * 2)


def test_a_series_of_any_length_fits_its_memory(run: Run) -> None:
    found = run(
        "util/series.js",
        """({ Series }) => {
          const series = new Series(["t", "v"], 64);
          for (let i = 0; i < 5000; i += 1) series.add({ t: i, v: 2 * i });
          const points = series.points("t", "v");
          return { count: series.count, first: points[0], last: points.at(-1),
            straight: points.every(({ x, y }) => y === 2 * x) };
        }""",
    )
    assert 32 <= found["count"] <= 64
    assert found["straight"]
    assert found["last"]["x"] > 4700


def measuring(screen: Any) -> Any:
    """The screen with its instruments open."""
    panel = screen.page.locator("#measure")
    if panel.get_attribute("open") is None:
        panel.locator("summary").click()
    expect(screen.page.get_by_role("heading", name="Line to the server")).to_be_visible()
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
    expect(screen.page.get_by_role("radio", name="Binomial")).to_be_disabled()
    expect(screen.page.locator("#tray-key")).to_contain_text("measured, 10,000 drops")
    screen.page.get_by_role("radio", name="20 balls").check()
    screen.seed.fill("1000")
    screen.drop.click()
    expect(screen.rows).to_have_count(20)
    expect(screen.page.locator("#fit-note")).to_contain_text("20 drops")
    counts = screen.api(f"rooms/{quick.room}")["stats"]["histogram"]
    p = run("model/statistics.js", "({ sameTest }, all) => sameTest(...all).p",
            [counts, simulated(screen, quick.board, 10_000)])  # fmt: skip
    shown = screen.page.locator("#fit-p").inner_text()
    assert float(shown.removeprefix("p = ")) == pytest.approx(p, abs=0.006)
    screen.shot("measure")


def test_a_triangle_is_compared_with_the_binomial_or_with_what_was_measured(opened: Open) -> None:
    screen = measuring(opened("/?room=triangle-9").ready())
    key = screen.page.locator("#tray-key")
    expect(key).to_contain_text("binomial, 9 fair rows")
    screen.page.get_by_role("radio", name="Measured").check()
    expect(key).to_contain_text("measured, 10,000 drops")
    expect(screen.page.locator("#returns-note")).to_contain_text(re.compile(r"Expected.*\d %"))
    screen.page.get_by_role("radio", name="Binomial").check()
    expect(key).to_contain_text("binomial")


def test_returns_are_the_mean_of_the_scores_with_its_doubt(opened: Open, quick: Quick) -> None:
    screen = measuring(opened(quick.page).ready())
    scores = []
    for seed in (42, 43, 44, 45):
        screen.seed.fill(str(seed))
        screen.drop.click()
        scores.append(screen.api(f"drops/{quick.board}/{seed}")["score"])
    expect(screen.rows).to_have_count(4)
    returns = screen.page.locator("#returns")
    expect(returns).to_contain_text("of 4 drops")
    doubt = 3.182446305 * np.std(scores, ddof=1) / 2
    expect(returns).to_contain_text(f"{100 * np.mean(scores):.1f} %")
    expect(returns).to_contain_text(f"± {100 * doubt:.1f}")


def test_one_ball_is_followed_and_its_speed_and_energy_drawn(opened: Open) -> None:
    screen = measuring(opened("/?room=triangle-16").ready())
    screen.seed.fill("42")
    screen.drop.click()
    expect(screen.page.locator("#ball-note")).to_have_text("Seed 42 is followed.")
    speed = screen.page.locator("#speed-plot")
    expect(speed).to_have_attribute("aria-label", re.compile(r"now [\d.]+ m/s, at most [\d.]+"))
    screen.landed(screen.api("drops/triangle-16/42")["bin"])
    screen.ready()
    screen.page.wait_for_timeout(500)
    board = screen.api("boards/triangle-16")["board"]
    frames = screen.api("drops/triangle-16/42/frames?fps=60")
    at = {name: index for index, name in enumerate(frames["fields"])}
    speeds = [math.hypot(row[at["vx"]], row[at["vy"]]) for row in frames["frames"]]
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
    # Found and clicked within one frame: on a busy machine the ball would be gone meanwhile.
    screen.page.wait_for_function(_CLICK_SILVER)
    expect(screen.page.locator("#ball-note")).to_have_text("Seed 77 is followed.")


# A click in the middle of the pixels of somebody else's ball, light and nearly grey; true once
# there was one, below the place where a click would drop.
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


def test_the_line_is_measured_while_something_moves_and_left_alone_at_rest(
    opened: Open,
) -> None:
    screen = measuring(opened("/?room=triangle-10").ready())
    screen.drop.click()
    expect(screen.page.locator("#latency")).to_have_text(re.compile(r"[\d.]+ ms"))
    expect(screen.page.locator("#received")).to_have_text(re.compile(r"[1-9][\d.]* k?B/s"))
    expect(screen.page.locator("#drawn")).to_have_text(re.compile(r"[1-9]\d* /s"))
    expect(screen.page.locator("#tick")).to_have_text(re.compile(r"^\d+$"))
    screen.ready()
    expect(screen.page.locator("#received")).to_have_text("0 B/s")
    screen.page.wait_for_timeout(500)
    sent = len(screen.sent)
    screen.page.wait_for_timeout(2500)
    assert len(screen.sent) == sent, "a table at rest is not asked"


def test_closed_instruments_ask_the_server_for_nothing(opened: Open) -> None:
    screen = opened("/?room=triangle-10", viewport={"width": 800, "height": 700}).ready()
    expect(screen.page.locator("#measure")).not_to_have_attribute("open", "")
    screen.drop.click()
    screen.ready()
    assert [json.loads(frame)["type"] for frame in screen.sent] == ["drop"]
