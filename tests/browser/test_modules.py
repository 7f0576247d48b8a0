"""The page's pure modules, run in the browser that will run them."""

import itertools
import json
import math
import random
from typing import Any

import pytest
from playwright.sync_api import Error

from tests.browser.conftest import ROOT, Run

GOLDEN = ROOT / "tests" / "golden"
G = 9.81  # m/s^2
TICK = 1.0 / 60.0  # s


def golden(name: str) -> Any:
    return json.loads((GOLDEN / name).read_text())


# The wire.


def test_golden_snapshots_decode_to_the_last_bit(run: Run) -> None:
    for example in golden("snapshots.json")["snapshots"]:
        decoded = run(
            "net/protocol.js",
            """({ decodeSnapshot }, { hex, extent, velocity_scale }) => {
              const bytes = Uint8Array.from(hex.match(/../g), (pair) => parseInt(pair, 16));
              const scale = { extent, velocityScale: velocity_scale };
              const all = decodeSnapshot(bytes.buffer, scale);
              return { ...all, ids: [...all.ids], x: [...all.x], y: [...all.y], vx: [...all.vx],
                vy: [...all.vy], angle: [...all.angle], bounced: [...all.bounced],
                asleep: [...all.asleep] };
            }""",
            example,
        )
        balls = example["balls"]
        assert (decoded["tick"], decoded["seq"]) == (example["tick"], example["seq"])
        assert decoded["count"] == len(balls)
        assert decoded["ids"] == [ball["id"] for ball in balls]
        for mine, theirs in [
            ("x", "x"),
            ("y", "y"),
            ("angle", "theta"),
            ("vx", "vx"),
            ("vy", "vy"),
        ]:
            assert decoded[mine] == [ball[theirs] for ball in balls], example["name"]
        assert decoded["asleep"] == [int(ball["asleep"]) for ball in balls]
        assert decoded["bounced"] == [int(ball["bounced"]) for ball in balls]


@pytest.mark.parametrize(
    ("hex_", "named"),
    [
        ("50", "1 bytes"),
        ("510100005802000011000000", "81"),
        ("500200005802000011000000", "version 2"),
        ("500101005802000011000000", "not 24"),
        ("50010000580200001100000000", "not 12"),
    ],
)
def test_bytes_that_are_no_snapshot_are_refused_by_name(run: Run, hex_: str, named: str) -> None:
    message = run(
        "net/protocol.js",
        """({ decodeSnapshot, ProtocolError }, hex) => {
          const bytes = Uint8Array.from(hex.match(/../g), (pair) => parseInt(pair, 16));
          const extent = { x_min: 0, x_max: 1, y_min: 0, y_max: 1 };
          try { decodeSnapshot(bytes.buffer, { extent, velocityScale: 1 }); }
          catch (error) { return error instanceof ProtocolError ? error.message : "stranger"; }
        }""",
        hex_,
    )
    assert named in message


def test_golden_events_decode_one_at_a_time_and_as_the_array_of_a_tick(run: Run) -> None:
    examples = golden("events.json")["events"]
    texts = [example["text"] for example in examples]
    whole = f"[{','.join(texts)}]"
    read = "({ decodeEvents }, text) => decodeEvents(text)"
    assert [run("net/protocol.js", read, text)[0] for text in texts] == [e["value"] for e in examples]
    assert run("net/protocol.js", read, whole) == [e["value"] for e in examples]


@pytest.mark.parametrize("text", ["", "{", "3", "null", "[null]", '{"type":"hello","protocol":2}'])
def test_text_that_is_no_event_is_refused(run: Run, text: str) -> None:
    with pytest.raises(Error, match=r"event|protocol 2"):
        run("net/protocol.js", "({ decodeEvents }, text) => decodeEvents(text)", text)


# Motion between snapshots.


def knot(t: float, x: float, y: float, vx: float, vy: float, **more: Any) -> dict[str, Any]:
    flags = {"angle": 0.0, "vIn": True, "vOut": True, "bounced": False}
    return {"t": t, "x": x, "y": y, "vx": vx, "vy": vy, **flags, **more}


def flight(state: dict[str, Any], t: float) -> tuple[float, float, float, float]:
    """Free fall without drag from a knot: x, y, vx, vy at time t."""
    dt = t - state["t"]
    x, y = state["x"] + dt * state["vx"], state["y"] + dt * (state["vy"] + 0.5 * G * dt)
    return x, y, state["vx"], state["vy"] + G * dt


def drawn(run: Run, cases: list[Any], drag: float = 0.0) -> list[list[list[float]]]:
    result: list[list[list[float]]] = run(
        "model/motion/interpolate.js",
        """({ poseBetween }, { cases, law }) => cases.map(([a, b, times]) =>
          times.map((t) => { const { x, y } = poseBetween(a, b, t, law); return [x, y]; }))""",
        {"cases": cases, "law": {"gravity": G, "drag": drag}},
    )
    return result


def test_a_parabola_is_drawn_exactly(run: Run) -> None:
    a = knot(2.0, 0.1, 0.5, 1.25, -2.0)
    x, y, vx, vy = flight(a, 2.0 + TICK)
    times = [2.0 + TICK * step / 10 for step in range(11)]
    for (px, py), t in zip(
        drawn(run, [[a, knot(2.0 + TICK, x, y, vx, vy), times]])[0], times, strict=True
    ):
        assert (px, py) == pytest.approx(flight(a, t)[:2], abs=1e-12)


def test_a_bounce_is_drawn_to_its_corner_and_not_cut(run: Run) -> None:
    chance = random.Random(1)
    cases, truths = [], []
    for _ in range(300):
        a = knot(1.0, 0.0, 0.0, chance.uniform(-3, 3), chance.uniform(0.5, 5))
        corner_t = 1.0 + TICK * chance.uniform(0.02, 0.98)
        x, y, vx, vy = flight(a, corner_t)
        after = knot(corner_t, x, y, vx + chance.uniform(-2, 2), -chance.uniform(0.3, 0.9) * vy)
        b = knot(1.0 + TICK, *flight(after, 1.0 + TICK), bounced=True)
        times = sorted([*(1.0 + TICK * step / 20 for step in range(21)), corner_t])
        cases.append([a, b, times])
        truths.append([flight(a if t <= corner_t else after, t)[:2] for t in times])
    for places, truth in zip(drawn(run, cases), truths, strict=True):
        for place, true in zip(places, truth, strict=True):
            assert place == pytest.approx(true, abs=1e-9)


def test_with_drag_and_the_wires_rounding_the_corner_is_off_by_less_than_a_millimetre(
    run: Run,
) -> None:
    chance = random.Random(2)
    drag = 2.2
    cases, truths = [], []

    def fall(state: dict[str, Any], t: float) -> tuple[float, float, float, float]:
        dt = t - state["t"]
        decay = math.exp(-drag * dt)
        end = G / drag
        vx, vy = state["vx"] * decay, end + (state["vy"] - end) * decay
        x = state["x"] + state["vx"] * (1 - decay) / drag
        return x, state["y"] + end * dt + (state["vy"] - end) * (1 - decay) / drag, vx, vy

    for _ in range(300):
        a = knot(1.0, 0.0, 0.0, chance.uniform(-3, 3), chance.uniform(0.5, 4))
        corner_t = 1.0 + TICK * chance.uniform(0.02, 0.98)
        x, y, vx, vy = fall(a, corner_t)
        after = knot(corner_t, x, y, vx + chance.uniform(-2, 2), -chance.uniform(0.3, 0.9) * vy)
        bx, by, bvx, bvy = fall(after, 1.0 + TICK)
        b = knot(
            1.0 + TICK,
            round(bx, 4),
            round(by, 4),
            round(bvx * 1024) / 1024,
            round(bvy * 1024) / 1024,
            bounced=True,
        )
        cases.append([a, b, [corner_t]])
        truths.append((x, y))
    for places, truth in zip(drawn(run, cases, drag), truths, strict=True):
        assert math.dist(places[0], truth) < 1e-3


def test_a_bounce_whose_flag_was_lost_with_its_snapshot_is_found_by_the_velocities(
    run: Run,
) -> None:
    a = knot(1.0, 0.0, 0.0, 1.0, 3.0)
    corner_t = 1.0 + 1.5 * TICK
    x, y, vx, vy = flight(a, corner_t)
    after = knot(corner_t, x, y, vx, -0.7 * vy)
    b = knot(1.0 + 3 * TICK, *flight(after, 1.0 + 3 * TICK))
    place = drawn(run, [[a, b, [corner_t]]])[0][0]
    assert place == pytest.approx((x, y), abs=1e-9)


_PATH = """({ Path }, { knots, times, law }) => {
  const path = new Path(law);
  for (const knot of knots) path.add({ ...knot });
  return times.map((t) => { const { x, y, angle } = path.poseAt(t); return [x, y, angle]; });
}"""


def test_a_contact_told_late_bends_the_path_as_one_told_in_time(run: Run) -> None:
    a = knot(1.0, 0.0, 0.0, 1.0, 3.0, angle=6.2)
    corner_t = 1.0 + 0.4 * TICK
    x, y, vx, vy = flight(a, corner_t)
    after = knot(corner_t, x, y, -vx, -0.7 * vy)
    b = knot(1.0 + TICK, *flight(after, 1.0 + TICK), bounced=True, angle=0.1)
    contact = knot(corner_t, x, y, 0.0, 0.0, vIn=False, vOut=False)
    law = {"gravity": G, "drag": 0.0}
    times = [1.0 + TICK * step / 20 for step in range(21)]
    in_time = run("model/motion/path.js", _PATH, {"knots": [a, contact, b], "times": times, "law": law})
    late = run("model/motion/path.js", _PATH, {"knots": [a, b, contact], "times": times, "law": law})
    assert in_time == late
    for (px, py, angle), t in zip(in_time, times, strict=True):
        assert (px, py) == pytest.approx(flight(a if t <= corner_t else after, t)[:2], abs=1e-9)
        turned = 6.2 + (0.1 + 2 * math.pi - 6.2) * (t - 1.0) / TICK
        assert math.cos(angle - turned) == pytest.approx(1.0, abs=1e-12)


def test_without_news_a_ball_flies_on_a_little_and_then_waits(run: Run) -> None:
    a = knot(1.0, 0.0, 0.0, 1.0, 1.0)
    law = {"gravity": G, "drag": 0.0}
    places = run("model/motion/path.js", _PATH, {"knots": [a], "times": [1.03, 2.0, 3.0], "law": law})
    assert places[0][:2] == pytest.approx(flight(a, 1.03)[:2])
    assert places[1] == places[2]


# The clock.

_CLOCK = """({ TickClock }, { stamps, frames, restarts }) => {
  const clock = new TickClock({ rate: 60 });
  const shown = [];
  let next = 0;
  for (const now of frames) {
    for (; next < stamps.length && stamps[next][1] <= now; next += 1) {
      if (restarts.includes(next)) clock.restart();
      clock.observe(...stamps[next]);
    }
    shown.push(clock.renderTick(now));
  }
  return shown;
}"""


def shown_ticks(run: Run, stamps: Any, frames: Any, restarts: Any = ()) -> list[float]:
    argument = {"stamps": stamps, "frames": frames, "restarts": list(restarts)}
    ticks: list[float] = run("net/tick-clock.js", _CLOCK, argument)
    return ticks


def test_the_picture_stays_three_ticks_behind_a_steady_server(run: Run) -> None:
    stamps = [(tick, 1000 + tick * 1000 / 60) for tick in range(300)]
    frames = [1000 + frame * 1000 / 144 for frame in range(1, 700)]
    for now, tick in zip(frames, shown_ticks(run, stamps, frames), strict=True):
        assert tick == pytest.approx((now - 1000) * 60 / 1000 - 3, abs=0.05)


def test_the_picture_never_runs_backwards_through_jitter_and_drift(run: Run) -> None:
    chance = random.Random(3)
    fast = 1.002  # the server's clock gains two seconds in a thousand
    stamps, arrived = [], 0.0
    for tick in range(60 * 120):
        arrived = max(arrived, tick * 1000 / 60 / fast + chance.expovariate(1 / 6.0))
        stamps.append((tick, arrived))
    frames = [200 + frame * 1000 / 60 for frame in range(60 * 115)]
    ticks = shown_ticks(run, stamps, frames)
    steps = [after - before for before, after in itertools.pairwise(ticks)]
    assert min(steps[1:]) >= 0.9 - 1e-6
    assert max(steps[1:]) <= 1.1 + 1e-6
    behind = [now * 60 * fast / 1000 - tick for now, tick in zip(frames, ticks, strict=True)]
    assert max(behind[600:]) < 18
    assert min(behind[600:]) > 2, "the drift of 14 ticks was followed"


def test_a_room_that_slept_is_shown_at_its_own_tick_again(run: Run) -> None:
    stamps = [(tick, tick * 1000 / 60) for tick in range(100)]
    woken = len(stamps)
    stamps += [(100 + tick, 60_000 + tick * 1000 / 60) for tick in range(100)]
    frames = [*(frame * 1000 / 60 for frame in range(1, 100)), 60_100.0, 60_200.0]
    ticks = shown_ticks(run, stamps, frames, [woken])
    assert ticks[-1] == pytest.approx(100 + 12 - 3, abs=0.6)


# The rest.


def test_the_expected_histogram_is_the_binomial(run: Run) -> None:
    for rows in (8, 16):
        chances = run("instruments/binomial.js", "({ binomial }, rows) => binomial(rows)", rows)
        assert chances == [math.comb(rows, k) / 2**rows for k in range(rows + 1)]
    assert run("instruments/binomial.js", "({ expectedOf }) => expectedOf('classic', 9)") is None
    named = run("instruments/binomial.js", "({ expectedOf }) => expectedOf('triangle-8-high', 9)")
    assert "binomial" in named["label"]


def test_a_start_is_kept_inside_what_the_board_allows(run: Run) -> None:
    board = {"drop": {"x": 0.0, "jitter": 0.30870588235294116}}
    allowed = "({ allowedStart }, [board, slots, x]) => allowedStart(board, slots, x)"
    for x in (-5.0, -0.3087059, 0.30870588235294116, 0.31, 5.0):
        assert abs(run("paint/geometry.js", allowed, [board, [], x])) <= board["drop"]["jitter"]
    assert run("paint/geometry.js", allowed, [board, [], 0.12345]) == 0.1234
    board = {"drop": {"x": 0.0, "jitter": 0.1, "reach": 0.5}}
    assert run("paint/geometry.js", allowed, [board, [], 5.0]) == 0.5
    assert run("paint/geometry.js", allowed, [board, [-1.5, 0.25, 1.5], 0.8]) == 0.25


def test_a_score_takes_the_colour_of_its_step(run: Run) -> None:
    theme = json.loads((ROOT / "static" / "theme.json").read_text())
    pick = "({ payoutColour }, [steps, score]) => payoutColour(steps, score).from"
    for score, step in [(0, 0), (0.3, 0), (0.5, 0.45), (1, 1), (1.4, 1), (110, 80), (1000, 80)]:
        assert run("paint/theme.js", pick, [theme["payout"], score]) == step
    assert theme["light"].keys() == theme["dark"].keys()


def contrast(one: str, two: str) -> float:
    """WCAG 2 contrast ratio of two colours in hex sRGB."""

    def luminance(colour: str) -> float:
        parts = [int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)]
        linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    low, high = sorted((luminance(one), luminance(two)))
    return (high + 0.05) / (low + 0.05)


def test_all_text_can_be_read_on_its_ground() -> None:
    theme = json.loads((ROOT / "static" / "theme.json").read_text())
    for name in ("light", "dark"):
        colours = theme[name]
        for text, grounds in {
            "ink": ("page", "pageDeep", "case", "caseShade", "field"),
            "inkSoft": ("page", "pageDeep", "case", "field"),
            "link": ("page", "pageDeep"),
            "bad": ("page", "pageDeep"),
            "accentInk": ("accent",),
            "counterInk": ("counter",),
            "trayInk": ("tray",),
        }.items():
            for ground in grounds:
                ratio = contrast(colours[text], colours[ground])
                assert ratio >= 4.5, f"{name}: {text} on {ground} is {ratio:.2f}"
        # What shows where a field or a button ends needs less than text does.
        assert contrast(colours["line"], colours["page"]) >= 3
        assert contrast(colours["focus"], colours["page"]) >= 3
    for step in theme["payout"]:
        assert contrast(step["fill"], step["ink"]) >= 4.5, step
