"""The benchmarks run, print what they should, and detect faults; their speed is not tested."""

import asyncio
import io
import json
import math
import platform
import socket

import numpy as np
import pytest
from PIL import Image

from benchmarks.accuracy import energy
from benchmarks.contestants import node
from benchmarks.contestants.box2d import Box2d
from benchmarks.contestants.chipmunk import Chipmunk
from benchmarks.contestants.common import Contestant, Paths
from benchmarks.contestants.naive import Naive
from benchmarks.contestants.ours import Exact, Stepped
from benchmarks.harness import machine
from benchmarks.harness.clock import Sample, in_turns
from benchmarks.harness.effort import Effort, MissingError
from benchmarks.harness.report import Section, Table, length, spread
from benchmarks.scenes import boards as scenes
from benchmarks.scenes import random_boards
from benchmarks.serving import fan_out, page, pictures, stream, wire
from benchmarks.serving import process as serving
from benchmarks.serving.attack.player import lateness
from benchmarks.speed import arithmetic, operations, worlds
from benchmarks.stability import invariants, torture
from plinko.engine import drop, drop_many

QUICK = Effort(quick=True, rounds=1, node=False)


def test_contestants_take_turns_and_the_first_round_is_dropped() -> None:
    order: list[str] = []

    def job(name: str) -> float:
        order.append(name)
        return float(len(order))

    found = in_turns({"a": lambda: job("a"), "b": lambda: job("b")}, 2)
    assert order == ["a", "b", "b", "a", "a", "b"]
    assert found == {"a": Sample((4.0, 5.0)), "b": Sample((3.0, 6.0))}


def test_a_ratio_is_taken_round_by_round() -> None:
    slow_machine_in_round_two = Sample((1.0, 10.0)), Sample((2.0, 20.0))
    assert slow_machine_in_round_two[1].over(slow_machine_in_round_two[0]).values == (2.0, 2.0)


def test_tables_are_markdown_with_median_and_spread() -> None:
    text = Table("Speed", ["who", "s"], [["a", spread(Sample((3.0, 1.0, 2.0)))]], ["Why."]).text()
    assert text.splitlines()[:5] == [
        "## Speed",
        "",
        "| who |          s |",
        "| --- | ---------: |",
        "| a   | 2 (1 to 3) |",
    ]
    assert text.endswith("Why.")


@pytest.mark.parametrize(
    ("metres", "text"),
    [(0.0, "0"), (1.5, "1.5 m"), (0.25, "250 mm"), (3.2e-6, "3.2 µm"), (4e-16, "4.0e-16 m")],
)
def test_lengths_have_fitting_units(metres: float, text: str) -> None:
    assert length(metres) == text


def test_the_machine_is_named() -> None:
    about = machine.describe()
    assert about["processor"]
    assert int(about["cores"]) >= 1
    assert about["numpy"] == np.__version__


@pytest.mark.parametrize("rows", [8, 13])
def test_lattices_of_any_width_give_the_same_walk(rows: int) -> None:
    """Costs on boards of different width are comparable only if the path is the same."""
    narrow, wide = (scenes.lattice(rows, n, scenes.FULL) for n in (32, 64))
    assert len(wide.pegs) > 1.9 * len(narrow.pegs)
    assert narrow.drop == wide.drop
    paths = [drop_many(board, range(200), threads=1).impact_count for board in (narrow, wide)]
    assert paths[0].tolist() == paths[1].tolist()


@pytest.mark.long("it measures")
def test_arithmetic_is_measured_in_positive_nanoseconds() -> None:
    for job in arithmetic.jobs(sweeps=10).values():
        assert job() > 0.0


def test_operations_are_counted() -> None:
    """A drop with few impacts takes tens to hundreds of operations per impact, not thousands."""
    board = scenes.revised(scenes.lattice(8, 8, scenes.PLAIN))
    counts = operations.count_apart(board.to_json(), 1)
    assert 20.0 < counts["add"] < 2000.0
    assert 20.0 < counts["multiply"] < 2000.0
    assert counts["root"] > 0.0


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


@pytest.mark.long("it measures")
def test_timed_contestants_return_seconds() -> None:
    board = scenes.triangle(8, scenes.PLAIN)
    for contestant in everyone():
        assert contestant.seconds(board, np.array([0.1]), 1.0 / 60.0) > 0.0


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


def test_a_recorded_path_is_read_between_its_steps() -> None:
    y = np.arange(5.0)
    positions = np.stack([np.zeros((5, 1)), y[:, None]], axis=-1)
    paths = Paths(0.5, positions, np.zeros_like(positions))
    assert paths.at(np.array([[0.0, 0.75, 2.0]]))[0, :, 1].tolist() == [0.0, 1.5, 4.0]


def test_the_watch_sees_tunnelling() -> None:
    pegs, walls = np.array([[0.0, 0.0, 0.05]]), np.array([[1.0, -1.0, 1.0, 1.0]])
    away, overlapping = np.array([0.0, 0.0]), np.array([-0.2, -0.12])
    depth = invariants.deepest(away, overlapping, pegs, walls, 0.1)
    assert depth == pytest.approx(0.03)
    through = invariants.deepest(np.array([0.7, 1.3]), np.array([0.0, 0.1]), pegs, walls, 0.1)
    assert through == pytest.approx(0.1)
    beside = invariants.deepest(np.array([0.7, 0.75]), np.array([0.0, 0.1]), pegs, walls, 0.1)
    assert beside == 0.0


def test_random_boards_are_valid_and_repeatable() -> None:
    boards = [random_boards.random_board(seed) for seed in range(3)]
    assert len({board.digest for board in boards}) == 3
    assert random_boards.random_board(1).digest == boards[1].digest
    low, high = -boards[0].drop.jitter, boards[0].drop.jitter
    assert all(low <= x <= high for x in random_boards.starts(boards[0], 50, 0))


@pytest.mark.parametrize("solver", ["exact", "stepped"])
def test_random_boards_do_no_harm(solver: str) -> None:
    found = invariants.Findings()
    for seed in range(4):
        board = random_boards.random_board(seed)
        found.add(
            invariants.examine(board, random_boards.starts(board, 6, seed), {"solver": solver})
        )
    assert found.drops == 24
    assert dict(found.faults) == {}, found.kept


def test_every_scene_of_the_torture_catalogue_can_be_made() -> None:
    """This includes scenes that the validator would refuse, where drops take hours."""
    names = [scene.name for scene in torture.catalogue(1)]
    assert len(set(names)) == len(names)


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


def test_bands_are_seen() -> None:
    """An animation with six colours has visible bands."""
    d = pictures.four_seconds()
    from plinko.app.render import drop_animation

    good = drop_animation(d, "gif", fps=5)
    with Image.open(io.BytesIO(good)) as frames:
        shown = []
        for number in range(getattr(frames, "n_frames", 1)):
            frames.seek(number)
            few = frames.convert("RGB").quantize(6, dither=Image.Dither.NONE)
            shown.append(few.convert("RGB"))
    buffer = io.BytesIO()
    shown[0].save(buffer, "WEBP", save_all=True, append_images=shown[1:], lossless=True, method=0)
    assert pictures.bands(d, good, 5) <= pictures.BAND
    assert pictures.bands(d, buffer.getvalue(), 5) > 2.0 * pictures.BAND


@pytest.mark.long("it measures")
def test_moving_worlds_are_timed_with_and_without_features() -> None:
    section = Section("features")
    worlds.run(section, QUICK)
    assert [row[0] for row in section.tables[0].rows] == ["ball-ball pairs", "diagnostics"]
    assert section.data["worlds"]["ball-ball pairs/with"]["median"] > 0
    assert worlds._box(5) == worlds._box(5, asked=True), "asking changes nothing"


def test_the_page_is_judged_by_the_thread_that_draws() -> None:
    def event(name: str, thread: int, start: float, took: float) -> dict[str, object]:
        return {"name": name, "ph": "X", "pid": 1, "tid": thread, "ts": start, "dur": took}

    frames = [event("FireAnimationFrame", 7, 1000.0 * at, 2000.0) for at in (0, 20, 40)]
    elsewhere = [event("Layout", 8, 0.0, 99_000.0), event("FireAnimationFrame", 8, 0.0, 1.0)]
    trace = page.read([*frames, *elsewhere, event("Layout", 7, 0.0, 9000.0)])
    assert trace.rate == pytest.approx(50.0)
    assert trace.intervals == [20.0, 20.0]
    assert trace.of(page.LAYOUT) == [9.0]
    assert page.quantile([3.0, 1.0, 2.0], 50) == 2.0
    with pytest.raises(MissingError, match="no frame"):
        page.read(elsewhere[:1])


@pytest.mark.long("it measures")
def test_paths_take_fewer_bytes_than_snapshots() -> None:
    section = Section("stream")
    wire.compare(section, QUICK)
    assert len(section.tables[0].rows) == 2 * len(wire.BOARDS)
    for name, found in section.data["wire"].items():
        assert 0 < found["paths"] < found["snapshots"], name
        assert found["paths"] < found["all_paths"] < found["all_snapshots"], name
        # 12 bytes of header, 12 per ball, and less than 5 of framing, 60 times a second
        assert 720 < found["snapshots"] < 60 * 29, name


def test_lateness_is_read_from_a_histogram() -> None:
    buckets = [(0.001, 50.0), (0.004, 90.0), (0.008, 100.0), (math.inf, 100.0)]
    assert stream.share_within(buckets, 0.004) == 0.9
    assert stream.quantile(buckets, 0.25) == pytest.approx(0.0005)
    assert stream.quantile(buckets, 0.7) == pytest.approx(0.0025)
    assert stream.quantile(buckets, 0.99) == pytest.approx(0.0076)


@pytest.mark.long("it measures")
def test_the_bare_loop_sends_what_it_is_asked_to() -> None:
    with fan_out._bare(2) as bare:
        host, _, port = bare.address.rpartition(":")
        place = host, int(port)
        with socket.create_connection(place) as one, socket.create_connection(place) as two:
            assert asyncio.run(fan_out._send(bare, 700, 0.2)) > 0
            for connection in (one, two):
                data = b""
                while len(data) < 12 * 700:
                    data += connection.recv(65536)
                assert data == bytes(12 * 700)


@pytest.mark.long("it measures a server")
def test_a_server_is_watched_from_outside_and_stopped() -> None:
    if not serving.can_watch():
        pytest.skip("this system tells nothing of other processes")
    with serving.serving(["--max-rooms", "5"]) as server:
        assert server.metrics()["plinko_rooms"] == 1
        assert server.resident > 1e7
        before = server.cpu
        server.metrics()
        assert server.cpu > before > 0
        assert server.process.poll() is None
    assert server.process.poll() == 0


def test_a_tick_s_delay_excludes_ticks_that_were_given_up() -> None:
    on_time = [(tick, 100.0 + tick / 60.0) for tick in range(300)]
    assert lateness(on_time) == pytest.approx([0.0] * 300, abs=1e-9)
    once = [(tick, at + (0.009 if tick == 150 else 0.0)) for tick, at in on_time]
    assert lateness(once)[149:152] == pytest.approx([0.0, 0.009, 0.0], abs=1e-9)
    # A stall of six ticks: the server made up for five in one message, and skipped one.
    stalled = [
        (tick, at + (0.0 if tick < 150 else 1.0 / 60.0))
        for tick, at in on_time
        if not 150 <= tick < 154
    ]
    assert max(lateness(stalled)) == pytest.approx(0.0, abs=1e-9)
    # For more than a second every tick is late by nearly one tick; none was skipped.
    slow = [(tick, at + (0.014 if tick >= 100 else 0.0)) for tick, at in on_time]
    assert lateness(slow)[200:] == pytest.approx([0.014] * 100, abs=1e-9)
    # The first snapshot came late, and the next tick was skipped.
    begun = [(tick, at + (1.0 / 60.0 if tick else 0.0044)) for tick, at in on_time]
    assert lateness(begun) == pytest.approx([0.0044] + [0.0] * 299, abs=1e-9)
