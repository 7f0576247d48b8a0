"""Balls are drawn where they are, at any frame rate and with late messages, in bounded memory."""

import random
from bisect import bisect_right
from typing import Any

import numpy as np
import pytest

from plinko.engine import Board, drop
from tests.js.conftest import Run

TICK = 1.0 / 60.0  # s

# Plays one ball from messages that arrive late and unevenly, with a display's frames in between.
# Returns table time and place in each frame, and the largest number of keyframes kept.
_PLAY = """async ({ Table }, { hello, accepted, stamps, times, rate }, load) => {
  const { TickClock } = await load("net/tick-clock.js");
  const table = new Table(hello);
  const clock = new TickClock({ rate });
  table.accept(accepted, true);
  const shown = [];
  let next = 0;
  let kept = 0;
  for (const now of times) {
    for (; next < stamps.length && stamps[next].at <= now; next += 1) {
      const { tick, at, contacts, ball, landed } = stamps[next];
      clock.observe(tick, at);
      for (const contact of contacts) table.applyContact(contact);
      if (landed) table.applyLanded(landed);
      if (!ball) continue;
      const [x, y, angle, vx, vy, bounced] = ball;
      table.applySnapshot({ tick, balls: [{ id: 0, x, y, angle, vx, vy, bounced }] });
    }
    const t = clock.renderTick(now) / rate;
    const scene = table.sceneAt(t, now / 1000);
    for (const { x, y } of scene.balls) shown.push([t, x, y]);
    for (const { path } of table.balls.values()) kept = Math.max(kept, path.keyframes.length);
  }
  return { shown, kept };
}"""


def told(board: Board, seed: int, jitter: float) -> tuple[dict[str, Any], Any]:
    """The messages of a drop in snapshots: ticks, rounded places, contacts above 0.05 m/s."""
    chance = random.Random(seed)
    fall = drop(board, seed=seed)
    ticks = np.arange(1, int(fall.duration / TICK) + 1)
    states = fall.states(ticks * TICK)
    hits = [row for row in fall.impacts if int(row["kind"]) in (0, 1)]
    at = [float(hit["t"]) for hit in hits]
    stamps, arrived = [], 0.0
    for tick, state in zip(ticks.tolist(), states, strict=True):
        since = hits[bisect_right(at, (tick - 1) * TICK) : bisect_right(at, tick * TICK)]
        arrived = max(arrived, 1000 * tick * TICK + chance.expovariate(1.0) * jitter)
        stamps.append(
            {
                "tick": tick,
                "at": arrived,
                "contacts": [contact(tick, hit) for hit in since],
                "ball": wired(state, bool(since)),
            }
        )
    last = {"ball": 0, "bin": fall.bin, "score": fall.score, "t": fall.duration}
    stamps.append(
        {
            "tick": len(ticks) + 1,
            "at": arrived + 1000 * TICK,
            "contacts": [],
            "landed": {**last, "x_end": fall.x_end},
        }
    )
    return {
        "hello": {"board": board.to_dict(), "tick_rate": 60, "tick": 0, "balls": []},
        "accepted": {"ball": 0, "seed": str(seed), "x": fall.x_start, "tick": 0},
        "stamps": stamps,
        "rate": 60,
    }, fall


def contact(tick: int, hit: Any) -> dict[str, Any]:
    places = {name: float(hit[name]) for name in ("t", "x", "y")}
    speed = float(np.hypot(hit["vx"], hit["vy"]))
    return {
        **places,
        "ball": 0,
        "tick": tick,
        "kind": int(hit["kind"]),
        "index": int(hit["index"]),
        "speed": speed,
    }


def wired(state: Any, bounced: bool) -> list[Any]:
    """A ball's state at about a snapshot's resolution: 1/8192 m and 1/1024 m/s."""
    x, y = (round(float(state[name]) * 8192) / 8192 for name in ("x", "y"))
    vx, vy = (round(float(state[name]) * 1024) / 1024 for name in ("vx", "vy"))
    return [x, y, float(state["theta"]), vx, vy, bounced]


@pytest.mark.parametrize("hertz", [30, 60, 144])
def test_displays_show_the_true_place_and_cut_no_bounce_short(run: Run, hertz: int) -> None:
    board = Board.preset("triangle-12")
    for seed in (1, 2, 3):
        given, fall = told(board, seed, jitter=4.0)
        end = given["stamps"][-1]["at"] + 300
        times = np.arange(200.0, end, 1000 / hertz).tolist()
        played = run("model/table/table.js", _PLAY, {**given, "times": times})
        shown = [row for row in played["shown"] if 0.0 < row[0] < fall.duration]
        times = np.array([row[0] for row in shown])
        assert len(times) > 0.8 * hertz * fall.duration
        true = fall.states(times)
        off = np.hypot([row[1] for row in shown] - true["x"], [row[2] for row in shown] - true["y"])
        # A slow contact that is not sent rounds a corner slightly; a missed bounce is 20 mm off.
        assert np.quantile(off, 0.99) < 1e-3, f"seed {seed}: {np.quantile(off, 0.99)}"
        assert off.max() < 5e-3, f"seed {seed}: {off.max()} at {times[off.argmax()]}"
        steps = np.diff(times) * hertz
        assert steps.min() > 0.88
        assert steps.max() < 1.12


def test_a_ball_keeps_half_a_second_of_its_path_in_a_long_fall(run: Run) -> None:
    moon = Board.preset("triangle-16").to_dict()
    moon.update(gravity=0.4, name="slow")
    given, fall = told(Board.from_json(moon), 5, jitter=4.0)
    times = np.arange(200.0, given["stamps"][-1]["at"], 1000 / 60).tolist()
    played = run("model/table/table.js", _PLAY, {**given, "times": times})
    assert fall.duration > 8
    assert played["kept"] < 90
