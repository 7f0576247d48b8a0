"""Each benchmark runs, its contestants play the same scenes, and random boards do no harm."""

import json
import math
import platform

import numpy as np
import pytest

from benchmarks.accuracy import energy
from benchmarks.contestants import node
from benchmarks.contestants.box2d import Box2d
from benchmarks.contestants.chipmunk import Chipmunk
from benchmarks.contestants.common import Contestant
from benchmarks.contestants.naive import Naive
from benchmarks.contestants.ours import Exact, Stepped
from benchmarks.harness.effort import Effort, MissingError
from benchmarks.harness.report import Section
from benchmarks.scenes import boards as scenes
from benchmarks.serving import pictures
from benchmarks.stability import invariants, torture
from benchmarks.suite import BENCHMARKS, run
from plinko.engine import drop, drop_many

QUICK = Effort(quick=True, rounds=1, node=False)
MEASURED = pytest.mark.long("it measures")


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in {"certified", "growth"} else MEASURED)
        for name in BENCHMARKS
        if name not in {"literature", "pictures"}  # see test_literature.py, and below
    ],
)
def test_a_benchmark_runs_and_its_tables_can_be_recorded(name: str) -> None:
    try:
        section = run(name, QUICK)
    except MissingError as missing:
        pytest.skip(str(missing))
    assert section.tables
    assert all(table.rows for table in section.tables)
    assert json.loads(json.dumps(section.to_dict()))["tables"]


@pytest.mark.parametrize("rows", [8, 13])
def test_lattices_of_any_width_give_the_same_walk(rows: int) -> None:
    """Costs on boards of different width are comparable only if the path is the same."""
    narrow, wide = (scenes.lattice(rows, n, scenes.FULL) for n in (32, 64))
    assert len(wide.pegs) > 1.9 * len(narrow.pegs)
    assert narrow.drop == wide.drop
    paths = [drop_many(board, range(200), threads=1).impact_count for board in (narrow, wide)]
    assert paths[0].tolist() == paths[1].tolist()


def everyone() -> list[Contestant]:
    """All contestants that exist for this processor."""
    box2d = [Box2d()] if platform.machine() == "x86_64" else []
    return [Exact(), Stepped(), Naive(), Chipmunk(), *box2d]


@pytest.mark.long("it runs every engine")
def test_all_contestants_play_the_same_scene() -> None:
    """Before the first impact, contestants may differ only by the error of their step."""
    board = scenes.triangle(12, scenes.PLAIN)
    xs = np.array([0.05, -0.2])
    dt = 1.0 / 960.0
    first = min(float(drop(board, x=x).impacts["t"][0]) for x in xs.tolist())
    times = np.full((2, 1), 0.9 * first)
    fallen = 0.5 * board.gravity * times[0, 0] ** 2
    for contestant in everyone():
        seen = contestant.observe(board, xs, dt, times, 12.0)
        assert seen.positions[:, 0, 0] == pytest.approx(xs, abs=1e-6), contestant.name
        assert seen.positions[:, 0, 1] == pytest.approx(fallen, abs=2e-3), contestant.name
        assert ((seen.bins >= 0) & (seen.bins < board.bins.count)).all(), contestant.name
        assert seen.deepest < 0.02, contestant.name


def test_all_contestants_fall_through_air_alike() -> None:
    board = scenes.triangle(12, scenes.FULL)
    times = np.full((1, 1), 0.1)
    k, t = board.drag, 0.1
    fallen = board.gravity / k * (t - (1.0 - math.exp(-k * t)) / k)
    for contestant in everyone():
        seen = contestant.observe(board, np.zeros(1) + 0.01, 1.0 / 960.0, times, 1.0)
        assert seen.positions[0, 0, 1] == pytest.approx(fallen, abs=1e-3), contestant.name


def test_all_contestants_honour_restitution() -> None:
    section = Section("accuracy")
    energy.bounces(section, everyone(), (240,), QUICK)
    for name, found in section.data["bounces"]["restitution"].items():
        assert found == pytest.approx([0.7, 0.7], abs=0.03), name
    assert section.data["bounces"]["restitution"]["plinko exact"] == pytest.approx(
        [0.7, 0.7], abs=1e-12
    )


@pytest.mark.long("it runs every engine")
@pytest.mark.parametrize("module", node.ENGINES)
def test_node_engines_play_the_same_scene(module: str) -> None:
    node.check()
    board = scenes.triangle(12, scenes.PLAIN)
    engine = node.NodeEngine(module)
    try:
        times = np.array([[0.15]])  # before the first impact
        seen = engine.observe(board, np.array([0.05]), 1.0 / 960.0, times, 12.0)
        assert seen.positions[0, 0] == pytest.approx([0.05, 0.5 * 9.81 * 0.15**2], abs=3e-3)
        assert 0 <= seen.bins[0] < board.bins.count
    finally:
        engine.close()


@pytest.mark.long("a catalogue of hard scenes")
def test_the_torture_catalogue_does_no_harm_to_the_exact_solver() -> None:
    found = invariants.Findings()
    for scene in torture.catalogue(1):
        if (
            "drag 1000" not in scene.name and "e 1" not in scene.name
        ):  # drops there take a second each
            found.add(invariants.examine(scene.board, scene.xs[:2], {"solver": "exact"}))
    assert found.drops > 40
    assert dict(found.faults) == {}, found.kept


@pytest.mark.long("it measures")
def test_pictures_are_measured_and_their_aims_are_told() -> None:
    section = pictures.run(QUICK)
    assert [table.title.split()[0] for table in section.tables] == [
        "A",
        "A",
        "Pictures",
        "A",
        "Ticks",
    ]
    assert section.data["stream_frames"]["nobody"] == 0
    one, fifty = (section.data["stream_frames"][name] for name in ("1 viewer", "50 viewers"))
    assert one == fifty > 0
    assert section.data["drop_bytes"]["GIF"] < pictures.GIF_BYTES
    assert section.data["bands"]["GIF"] <= pictures.BAND
    json.dumps(section.to_dict())
