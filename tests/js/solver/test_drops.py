"""Motion, impacts and doubles in the page's modules, compared with the engine."""

import math
import random
from typing import Any

import pytest

from plinko.engine import Board, Drop, drop
from plinko.engine.constants import KIND_CONTACT_BEGIN
from plinko.engine.parameters import SolverName
from tests.js.conftest import Run

# Balls with little bounce on a slope and on pegs: they soon roll and slide.
RIDES = {
    "name": "rides",
    "drag": 0.3,
    "ball": {"radius": 0.1, "density": 3.0, "restitution": 0.2, "friction": 0.3},
    "peg_material": {"restitution": 0.1, "friction": 0.4},
    "wall_material": {"restitution": 0.1, "friction": 0.2},
    "pegs": [{"x": x, "y": 1.2, "radius": 0.3} for x in (-1.0, 0.0, 1.0)],
    "walls": [
        {"x1": -2.0, "y1": -1.0, "x2": -2.0, "y2": 3.0},
        {"x1": 2.0, "y1": -1.0, "x2": 2.0, "y2": 3.0},
        {"x1": -0.4, "y1": 2.0, "x2": 1.4, "y2": 2.5},
    ],
    "bins": {"y": 3.0, "edges": [-2.0, 0.0, 2.0], "multipliers": [2.0, 0.5]},
    "drop": {"x": 0.0, "y": 0.0, "jitter": 1.0},
}


def boards() -> list[Board]:
    return [Board.preset("triangle-12"), Board.preset("classic"), Board.from_json(RIDES)]


def given(done: Drop, fps: float, times: list[float]) -> dict[str, Any]:
    """The server's replies about a drop, made without a server, and times to sample."""
    impacts = done.impacts
    count = int(done.duration * fps) + 1
    frames = done.states([*(k / fps for k in range(count)), done.duration])
    before = done.states([math.nextafter(t, 0.0) for t in impacts["t"].tolist()]).tolist()
    for i in range(1, len(impacts)):
        if impacts["t"][i] == impacts["t"][i - 1]:
            last = impacts[i - 1]
            before[i] = (*(last[name] for name in ["t", "x", "y"]), before[i][3], *list(last)[3:6])
    return {
        "board": done.board.to_dict(),
        "record": done.to_dict(),
        "sampled": {
            "fields": list(frames.dtype.names or ()),
            "frames": frames.tolist(),
            "before": [[float(value) for value in row] for row in before],
        },
        "times": times,
    }


_STATES = """
({ Motion }, { board, record, sampled, times }) => {
  const motion = new Motion(board, record, sampled);
  return times.map((t) => motion.stateAt(t))
    .map(({ t, x, y, theta, vx, vy, omega }) => [t, x, y, theta, vx, vy, omega]);
}
"""


def test_the_page_flies_to_the_last_bit_as_the_engine_does(run: Run) -> None:
    """Between impacts the page computes the flight; on a surface it interpolates, within 1 µm."""
    rng = random.Random(7)
    rode = False
    for board in boards():
        for seed in range(4):
            done = drop(board, seed)
            kinds = done.impacts["kind"].tolist()
            events = [0.0, *done.impacts["t"].tolist()]
            times = sorted(rng.uniform(0, done.duration) for _ in range(200))
            seen = run("model/motion/drop.js", _STATES, given(done, 240.0, times))
            for time, mine, true in zip(times, seen, done.states(times).tolist(), strict=True):
                piece = sum(t <= time for t in events) - 1
                rides = piece > 0 and kinds[piece - 1] in (2, 3)
                rode = rode or rides
                if rides:
                    assert math.dist(mine[1:3], true[1:3]) < 1e-6, (board.name, seed, time)
                    assert mine == pytest.approx(list(true), abs=2e-3)
                else:
                    # Only the angle is summed in another order.
                    assert mine[1:3] + mine[4:] == [*true[1:3], *true[4:]], (board.name, seed)
                    assert mine[3] == pytest.approx(true[3], abs=1e-9)
    assert rode, "no ball rolled on a surface"


def test_a_stepped_drop_is_shown_at_its_substeps(run: Run) -> None:
    done = drop(Board.preset("triangle-12"), 5, solver="stepped", dt=1 / 60, substeps=4)
    times = [k * done.duration / 300 for k in range(300)]
    seen = run("model/motion/drop.js", _STATES, given(done, 240.0, times))
    for mine, true in zip(seen, done.states(times).tolist(), strict=True):
        assert math.dist(mine[1:3], true[1:3]) < 1e-9


@pytest.mark.parametrize(("solver", "fps"), [("exact", 1), ("stepped", 240)])
def test_drops_are_sampled_only_where_the_page_cannot_compute(
    run: Run, solver: SolverName, fps: float
) -> None:
    drops = (drop(Board.preset("triangle-8"), seed, solver=solver) for seed in range(100))
    record = next(d for d in drops if KIND_CONTACT_BEGIN not in d.impacts["kind"]).to_dict()
    needed = run(
        "model/motion/drop.js", "({ samplesNeeded }, record) => samplesNeeded(record)", record
    )
    assert needed == pytest.approx(fps)


_IMPACTS = """
async ({ impactOf, energyOf }, { board, record, sampled }, load) => {
  const { Motion } = await load("model/motion/drop.js");
  const { events } = new Motion(board, record, sampled);
  return events.map((event) => ({ ...impactOf(board, event), ...event,
    kinetic: energyOf(board, event.before).total - energyOf(board, event.after).total }));
}
"""


def test_impulses_obey_the_laws_of_impact(run: Run) -> None:
    """Newton's restitution, Coulomb's limit, and the spin from the same friction."""
    friction_seen = False
    for board in boards():
        for seed in range(3):
            ball = board.ball
            for impact in run("model/impact.js", _IMPACTS, given(drop(board, seed), 240.0, [])):
                if impact["kind"] > 1:
                    continue
                other = board.peg_material if impact["kind"] == 0 else board.wall_material
                restitution = max(ball.restitution, other.restitution)
                friction = math.sqrt(ball.friction * other.friction)
                normal = impact["normal"]
                assert math.hypot(normal["x"], normal["y"]) == pytest.approx(1.0)
                # Rounding of a difference of velocities of several m/s.
                rounding = 1e-13 * ball.mass
                size = impact["along"]
                bounce = ball.mass * (1 + restitution) * impact["approach"]
                assert size == pytest.approx(bounce, rel=1e-6, abs=rounding)
                assert size > -rounding
                assert abs(impact["across"]) <= friction * size * (1 + 1e-6) + rounding
                spin = impact["after"]["omega"] - impact["before"]["omega"]
                assert ball.inertia * spin == pytest.approx(
                    -ball.radius * impact["across"], rel=1e-6, abs=rounding
                )
                assert impact["lost"] == pytest.approx(impact["kinetic"], abs=1e-9)
                assert impact["lost"] > -rounding
                friction_seen = friction_seen or abs(impact["across"]) > 1e-3 * size
    assert friction_seen


_PARTING = """
async ({ Divergence }, { one, two, limit }, load) => {
  const { Motion } = await load("model/motion/drop.js");
  const [a, b] = [one, two].map(({ board, record, sampled }) => new Motion(board, record, sampled));
  const apart = new Divergence(a, b);
  return { parted: apart.parting(limit), growth: apart.growthPerHit(limit),
    hits: apart.overHits, rows: apart.overTime };
}
"""


def test_two_drops_part_when_the_engine_says_so(run: Run) -> None:
    board = Board.preset("triangle-16")
    one = drop(board, x=0.1)
    two = drop(board, x=0.1 + 1e-9)
    limit = board.ball.radius
    asked = {"one": given(one, 240, []), "two": given(two, 240, []), "limit": limit}
    said = run("replay/divergence.js", _PARTING, asked)

    def apart(t: float) -> float:
        (a,), (b,) = one.states([t]), two.states([t])
        return math.dist((a["x"], a["y"]), (b["x"], b["y"]))

    assert said["hits"][0]["y"] == pytest.approx(1e-9, rel=1e-6)
    for row in said["rows"][::97]:
        assert row["y"] == pytest.approx(apart(row["x"]), abs=1e-12)
    parted = said["parted"]
    if parted is None:  # both may land before they part
        assert max(apart(row["x"]) for row in said["rows"]) <= limit
        return
    assert apart(parted["t"]) == pytest.approx(limit, rel=1e-6)
    assert all(apart(row["x"]) <= limit for row in said["rows"] if row["x"] < parted["t"])
    hits = sum(kind < 2 and t <= parted["t"] for t, *_, kind, _ in one.impacts.tolist())
    assert parted["hits"] == hits
    assert said["growth"] == pytest.approx((limit / 1e-9) ** (1 / hits), rel=1e-5)


def test_the_same_drop_never_parts(run: Run) -> None:
    same = given(drop(Board.preset("triangle-8"), 3), 240, [])
    said = run("replay/divergence.js", _PARTING, {"one": same, "two": same, "limit": 0.01})
    assert said["parted"] is None
    assert said["growth"] is None
    assert {row["y"] for row in said["rows"]} == {0}
