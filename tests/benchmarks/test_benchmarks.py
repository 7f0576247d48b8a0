"""The benchmarks run, say what they should, and judge rightly; how fast they run is no claim."""

import asyncio
import io
import json
import math
import os
import platform
import socket
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

import engine
from benchmarks.accuracy import accuracy, energy, readme_table
from benchmarks.contestants import node
from benchmarks.contestants.box2d import Box2d
from benchmarks.contestants.chipmunk import Chipmunk
from benchmarks.contestants.common import Contestant, Paths
from benchmarks.contestants.naive import Naive
from benchmarks.contestants.ours import Exact, Stepped
from benchmarks.harness import machine
from benchmarks.harness.clock import Sample, in_turns
from benchmarks.harness.effort import Effort, MissingError
from benchmarks.harness.markers import fill
from benchmarks.harness.report import Section, Table, length, spread
from benchmarks.scenes import boards as scenes
from benchmarks.scenes import random_boards
from benchmarks.serving import fan_out, page, render, stream, wire
from benchmarks.serving import process as serving
from benchmarks.serving.attack.player import lateness
from benchmarks.speed import arithmetic, operations, stripped, worlds
from benchmarks.stability import invariants, torture
from engine import drop, drop_many
from tests.long import tries

ROOT = Path(__file__).parents[2]
QUICK = Effort(quick=True, rounds=1, node=False)


def test_contestants_take_turns_and_the_first_round_is_not_counted() -> None:
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
    assert text.splitlines()[2:5] == [
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


def test_the_page_keeps_its_words_and_gets_new_tables(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("Words.\n<!-- speed -->\nold\n<!-- /speed -->\nMore words.\n")
    fill(page, {"cores": "2"}, [Section("speed", [Table("T", ["x"], [["new"]])])], tmp_path)
    text = page.read_text()
    assert text.startswith("Words.\n<!-- speed -->")
    assert text.endswith("<!-- /speed -->\nMore words.\n")
    assert "new" in text
    assert "old" not in text
    with pytest.raises(MissingError, match="stability"):
        fill(page, {}, [Section("stability")], tmp_path)


@pytest.mark.parametrize("rows", [8, 13])
def test_lattices_of_any_width_give_the_same_walk(rows: int) -> None:
    """The cost against pegs is only a fair curve if the path stays what it is."""
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
    """Falling and bouncing off a floor once takes some operations, but not thousands."""
    board = scenes.revised(scenes.lattice(8, 8, scenes.PLAIN))
    counts = operations.count_apart(board.to_json(), 1)
    assert 20.0 < counts["add"] < 2000.0
    assert 20.0 < counts["multiply"] < 2000.0
    assert counts["root"] > 0.0


def everyone() -> list[Contestant]:
    """All that there are for this processor."""
    box2d = [Box2d()] if platform.machine() == "x86_64" else []
    return [Exact(), Stepped(), Naive(), Chipmunk(), *box2d]


@pytest.mark.long("it runs every engine")
def test_all_contestants_play_the_same_scene() -> None:
    """Until the first impact there is nothing to differ about but the step."""
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


@pytest.mark.long("a catalogue of hard scenes")
def test_the_torture_catalogue_does_no_harm_to_the_exact_solver() -> None:
    found = invariants.Findings()
    for scene in torture.catalogue(1):
        if "drag 1000" not in scene.name and "e 1" not in scene.name:  # those take a second a drop
            found.add(invariants.examine(scene.board, scene.xs[:2], {"solver": "exact"}))
    assert found.drops > 40
    assert dict(found.faults) == {}, found.kept


@pytest.mark.long("it measures")
def test_pictures_are_measured_and_their_aims_are_told() -> None:
    section = render.run(QUICK)
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
    assert section.data["drop_bytes"]["GIF"] < render.GIF_BYTES
    assert section.data["bands"]["GIF"] <= render.BAND
    json.dumps(section.to_dict())


def test_bands_are_seen() -> None:
    """An animation of six colours has them."""
    d = render.four_seconds()
    from app.render import drop_animation

    good = drop_animation(d, "gif", fps=5)
    with Image.open(io.BytesIO(good)) as frames:
        shown = []
        for number in range(getattr(frames, "n_frames", 1)):
            frames.seek(number)
            few = frames.convert("RGB").quantize(6, dither=Image.Dither.NONE)
            shown.append(few.convert("RGB"))
    buffer = io.BytesIO()
    shown[0].save(buffer, "WEBP", save_all=True, append_images=shown[1:], lossless=True, method=0)
    assert render.bands(d, good, 5) <= render.BAND
    assert render.bands(d, buffer.getvalue(), 5) > 2.0 * render.BAND


STRIPPED = """
from benchmarks.scenes import boards as scenes
from benchmarks.speed import stripped
with stripped.without("friction") as other:
    board = scenes.twin(other, scenes.triangle(8, scenes.PLAIN))
    print(other.drop_many(board, range({count})).x_end.tobytes().hex())
"""


@pytest.mark.long
def test_an_engine_without_a_feature_gives_the_same_bits() -> None:
    """Its kernels are as Python: to compile them all takes longer, and is left to test-long."""
    count = tries(8, 64)
    done = subprocess.run(
        [sys.executable, "-c", STRIPPED.format(count=count)],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(ROOT), "NUMBA_DISABLE_JIT": tries("1", "0")},
        capture_output=True,
        text=True,
        check=True,
    )
    ours = drop_many(scenes.triangle(8, scenes.PLAIN), range(count))
    assert done.stdout.strip() == ours.x_end.tobytes().hex()


@pytest.mark.parametrize("feature", stripped.CUTS)
def test_every_cut_still_finds_what_it_cuts(feature: str, tmp_path: Path) -> None:
    package = f"engine_without_{feature}"
    stripped.copy(package, stripped.CUTS[feature](), tmp_path)
    copied = [path.read_text() for path in (tmp_path / package).rglob("*.py")]
    assert any(f"from {package}." in text for text in copied)
    assert not any("from engine." in text for text in copied)


@pytest.mark.long("it measures")
def test_moving_worlds_are_timed_with_and_without_what_they_can_use() -> None:
    section = Section("features")
    worlds.run(section, QUICK)
    assert [row[0] for row in section.tables[0].rows] == ["ball-ball pairs", "diagnostics"]
    assert section.data["worlds"]["ball-ball pairs/with"]["median"] > 0
    done, digest = worlds._box(engine, 5)
    assert (done, digest) == worlds._box(engine, 5, asked=True), "asking changes nothing"


def test_the_command_prints_json_and_saves_plots(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from app.cli import plinko
    from benchmarks import suite

    def one_table(name: str, effort: Effort) -> Section:
        assert effort.quick
        section = Section(name, [Table("T", ["a"], [["1"]])], {"n": 1})
        section.plots["plot.png"] = lambda path: Path(path).touch()
        return section

    monkeypatch.setattr(suite, "run", one_table)
    arguments = ["bench", "all", "--quick", "--json", "--plots", str(tmp_path)]
    done = CliRunner().invoke(plinko, arguments)
    printed = json.loads(done.stdout)
    assert list(printed["sections"]) == list(suite.NAMES)
    assert printed["machine"]["python"]
    assert (tmp_path / "plot.png").exists()


def test_the_readme_shows_what_the_page_records(tmp_path: Path) -> None:
    (tmp_path / "docs").mkdir()
    page, short = tmp_path / "docs" / "benchmarks.md", tmp_path / "README.md"
    cells = dict.fromkeys(accuracy.COLUMNS, "-")
    cells |= dict(zip(readme_table.COLUMNS, ("1 µm", "2 mm", "3/3", "9"), strict=True))
    names = ["plinko exact", "Box2D 1/60", "Box2D 1/240", "(one rounding of the start)"]
    rows = [[name, *list(cells.values())[1:]] for name in names]
    table = Table(readme_table.TITLE, accuracy.COLUMNS, rows)
    page.write_text("<!-- accuracy -->\n<!-- /accuracy -->\n")
    short.write_text("Head\n\n<!-- benchmarks -->\nold\n<!-- /benchmarks -->\n\nTail\n")
    readme_table.renew(short, page)
    assert "No run is recorded yet" in short.read_text()
    section = Section("accuracy", [table], plots={readme_table.PLOT: lambda path: None})
    fill(page, {"python": "1"}, [section], tmp_path / "docs" / "images")
    assert f"![accuracy trial 16](images/{readme_table.PLOT})" in page.read_text()
    readme_table.renew(short, page)
    shown = short.read_text()
    assert shown.startswith(
        "Head\n\n<!-- benchmarks -->\n\n| contestant, dt in s | after impact 2 |"
    )
    assert shown.endswith("<!-- /benchmarks -->\n\nTail\n")
    assert "| Box2D 1/240 | 1 µm | 2 mm | 3/3 | 9 |" in shown
    assert "1/60" not in shown
    assert f"](docs/images/{readme_table.PLOT})" in shown
    assert "](docs/benchmarks.md)" in shown


def test_the_readme_is_that_of_the_recorded_run() -> None:
    recorded = (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8")
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert readme_table.summary(recorded, "docs/benchmarks.md") in text


def test_the_pages_show_every_plot_that_is_kept() -> None:
    pages = (ROOT / "docs" / name for name in ("benchmarks.md", "validation.md"))
    recorded = "".join(page.read_text(encoding="utf-8") for page in pages)
    kept = sorted(path.name for path in (ROOT / "docs" / "images").glob("bench-*.png"))
    assert kept
    assert [name for name in kept if f"](images/{name})" not in recorded] == []


def test_a_page_is_not_recorded_without_its_plots(tmp_path: Path) -> None:
    from app.cli import plinko

    page = tmp_path / "page.md"
    page.write_text("<!-- accuracy -->\nold\n<!-- /accuracy -->\n")
    done = CliRunner().invoke(plinko, ["bench", "accuracy", "--quick", "--page", str(page)])
    assert done.exit_code == 2
    assert "say with --plots where they are drawn" in done.output
    assert "old" in page.read_text()


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
def test_segments_take_fewer_bytes_than_snapshots() -> None:
    section = Section("stream")
    wire.compare(section, QUICK)
    assert len(section.tables[0].rows) == 2 * len(wire.BOARDS)
    for name, found in section.data["wire"].items():
        assert 0 < found["segments"] < found["snapshots"], name
        assert found["segments"] < found["all_segments"] < found["all_snapshots"], name
        # 12 bytes of header and 12 a ball, 60 times a second; and less than 5 of framing.
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


def test_ticks_are_late_by_what_they_lag_behind_the_schedule_and_not_by_those_given_up() -> None:
    on_time = [(tick, 100.0 + tick / 60.0) for tick in range(300)]
    assert lateness(on_time) == pytest.approx([0.0] * 300, abs=1e-9)
    once = [(tick, at + (0.009 if tick == 150 else 0.0)) for tick, at in on_time]
    assert lateness(once)[149:152] == pytest.approx([0.0, 0.009, 0.0], abs=1e-9)
    # A stall of six ticks: five were made up for in one message, and one was given up.
    stalled = [
        (tick, at + (0.0 if tick < 150 else 1.0 / 60.0))
        for tick, at in on_time
        if not 150 <= tick < 154
    ]
    assert max(lateness(stalled)) == pytest.approx(0.0, abs=1e-9)
    # For a second and more every tick is late by nearly one: that is late, not given up.
    slow = [(tick, at + (0.014 if tick >= 100 else 0.0)) for tick, at in on_time]
    assert lateness(slow)[200:] == pytest.approx([0.014] * 100, abs=1e-9)
    # The first one that was seen came late, and the one after it was given up.
    begun = [(tick, at + (1.0 / 60.0 if tick else 0.0044)) for tick, at in on_time]
    assert lateness(begun) == pytest.approx([0.0044] + [0.0] * 299, abs=1e-9)
