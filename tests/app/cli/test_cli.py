"""The command line prints the engine's results, and one line for invalid input."""

import gc
import json
import os
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from plinko.app import settings
from plinko.app.cli import COMMANDS, GROUPS
from plinko.app.cli.common import garbage_waits
from plinko.app.render import contact_sheet, density_picture, histogram_picture
from plinko.engine import Board, drop, drop_many, find_draw, preset_names
from plinko.engine.board.presets import TUNING, Tuning
from plinko.engine.board.worlds import WORLDS
from plinko.engine.drops.calibrate import UNSEEN, fit_of
from tests.app.cli.conftest import Terminal

BOARD = {
    "name": "my board",
    "width": 4.0,
    "height": 3.0,
    "pegs": [{"x": 0.0, "y": 1.0, "radius": 0.05}],
    "walls": [
        {"x1": -1.5, "y1": -1.0, "x2": -1.5, "y2": 3.0},
        {"x1": 1.5, "y1": -1.0, "x2": 1.5, "y2": 3.0},
    ],
    "bins": {"y": 2.5, "edges": [-1.5, 0.0, 1.5], "multipliers": [1.0, 2.0]},
    "drop": {"x": 0.0, "y": 0.0, "jitter": 0.5},
}


def lines_of(out: str) -> dict[str, str]:
    """The values that `plinko drop` prints, by their names."""
    return dict(line.split(maxsplit=1) for line in out.splitlines())


@pytest.fixture
def board_file(tmp_path: Path) -> Path:
    path = tmp_path / "board.json"
    path.write_text(json.dumps(BOARD))
    return path


# drop


@pytest.mark.parametrize("seed", [0, 42, 2**64 - 1])
def test_drop_prints_the_engines_drop(plinko: Terminal, seed: int) -> None:
    d = drop(Board.preset("triangle-8"), seed)
    lines = lines_of(plinko.run("drop", "triangle-8", "--seed", seed))
    assert lines["digest"] == d.digest
    assert lines["bin"] == f"{d.bin} of 0 to 8"
    assert lines["score"] == f"{d.score:g}"
    assert lines["seed"] == str(seed)
    assert lines["impacts"].startswith(f"{len(d.impacts)} (")
    assert f"{d.duration:.6f} s" in lines["end"]


@pytest.mark.parametrize(
    ("seed", "said"),
    [(21, set()), (7, {"error"}), (42, {"certain", "error"})],
)
def test_a_drop_says_what_rounding_may_have_done(
    plinko: Terminal, seed: int, said: set[str]
) -> None:
    """By default: whether it may decide the bin, or a printed digit."""
    d = drop("triangle-16", seed)
    lines = lines_of(plinko.run("drop", "triangle-16", "--seed", seed))
    assert lines.keys() & {"certain", "error", "growth"} == said
    assert ("certain" in said) == (not d.certain)
    assert ("error" in said) == (d.certainty.error > 5e-7)  # type: ignore[operator]
    stepped = plinko.run("drop", "triangle-16", "--seed", seed, "--solver", "stepped")
    assert "certain" not in stepped


def test_a_drop_says_how_sure_it_is_when_asked(plinko: Terminal) -> None:
    d = drop(Board.preset("triangle-8"), 42)
    shown = plinko.run("drop", "triangle-8", "--seed", 42, "--certainty")
    assert f"{d.amplification:.1e} m per metre" in shown
    record = plinko.json("drop", "triangle-8", "--seed", 42, "--certainty")
    assert record == d.to_dict(certainty=True)
    assert record["certain"] is True


def test_an_explicit_start_and_a_solver_are_passed_on(plinko: Terminal) -> None:
    record = plinko.json(
        "drop", "triangle-8", "--seed", 1, "--x", -0.0625,
        "--solver", "stepped", "--dt", "1/240", "--substeps", 2, "--correction", 0.4,
    )  # fmt: skip
    options: dict[str, Any] = {"dt": 1 / 240, "substeps": 2, "correction": 0.4}
    wanted = drop(Board.preset("triangle-8"), 1, x=-0.0625, solver="stepped", **options)
    assert record == wanted.to_dict()
    assert (record["x"], record["dt"]) == (-0.0625, 1 / 240)


def test_a_board_may_be_a_file_or_come_through_a_pipe(plinko: Terminal, board_file: Path) -> None:
    expected = drop(Board.from_json(BOARD), 5).to_dict()
    assert plinko.json("drop", board_file, "--seed", 5) == expected
    reading, writing = os.pipe()
    with open(reading, "rb"):
        with open(writing, "wb") as pipe:
            pipe.write(json.dumps(BOARD).encode())
        assert plinko.json("drop", f"/dev/fd/{reading}", "--seed", 5) == expected


def test_a_drop_may_start_at_x_without_a_seed(plinko: Terminal, tmp_path: Path) -> None:
    d = drop(Board.preset("triangle-8"), x=0.1)
    assert plinko.json("drop", "triangle-8", "--x", 0.1) == d.to_dict()
    assert plinko.run("drop", "triangle-8", "--x", 0.1, "--json") == d.to_json() + "\n"
    assert "seed     none\n" in plinko.run("drop", "triangle-8", "--x", 0.1)
    plinko.run("render", "triangle-8", tmp_path / "drop.png", "--x", 0.1)


# seeds


def test_seeds_are_those_that_drop_into_the_bin(plinko: Terminal) -> None:
    found = drop_many(Board.preset("triangle-8"), 300).bin
    wanted = [seed for seed in range(300) if found[seed] == 4 and seed > 10][:5]
    asked = ("seeds", "triangle-8", "--bin", 4, "--count", 5, "--after", 10)
    assert plinko.run(*asked).split() == [str(seed) for seed in wanted]
    told = plinko.json(*asked)
    assert told["seeds"] == [str(seed) for seed in wanted]
    assert told["board_digest"] == Board.preset("triangle-8").digest
    assert plinko.json("drop", "triangle-8", "--seed", wanted[0])["bin"] == 4


def test_a_draw_is_written_as_a_room_takes_it(plinko: Terminal, tmp_path: Path) -> None:
    odds = [9999, 0, 0, 0, 0, 0, 0, 0, 1]
    weights, file = tmp_path / "weights.json", tmp_path / "draw.json"
    weights.write_text(json.dumps(odds))
    asked = ("seeds", "triangle-8", "--per-bin", 2, "--draw")
    told = plinko.run(*asked, weights, "-o", file)
    assert told == f"{file}: 4 seeds, ready for POST rooms\n"
    written = json.loads(file.read_text())
    assert written == json.loads(plinko.run(*asked, ",".join(map(str, odds))))
    assert written == {
        "board": "triangle-8", "mode": "draw",
        "draw": find_draw("triangle-8", odds, per_bin=2),
    }  # fmt: skip
    board = tmp_path / "own.json"
    board.write_text(json.dumps(Board.preset("triangle-8").to_dict() | {"name": "own"}))
    own = json.loads(plinko.run("seeds", board, "--per-bin", 2, "--draw", weights))
    assert own["board"]["name"] == "own"
    for options, named in (
        (["--draw", "1,2"], "a list of 9"),
        (["--draw", tmp_path / "none.json"], "neither a list of weights such as 9999,1"),
        (["--draw", weights, "--bin", 4], "either --bin or --draw"),
        (["--draw", weights, "--aim", 0.01], "--aim 0.01: a draw has no aim"),
        ([], "either --bin or --draw"),
    ):
        assert named in plinko.refuses("seeds", "triangle-8", *options)


def test_seeds_that_run_out_are_printed_and_it_is_said(plinko: Terminal) -> None:
    found = drop_many(Board.preset("triangle-8"), range(2**64 - 15, 2**64))
    wanted = found.seed[found.bin == 4].tolist()
    asked = ("seeds", "triangle-8", "--bin", 4, "--after", 2**64 - 16, "--count")
    assert plinko.run(*asked, len(wanted)).split() == [str(seed) for seed in wanted]
    code, out, err = plinko.try_run(*asked, 16)
    assert (code, out.split()) == (2, [str(seed) for seed in wanted])
    assert f"only {len(wanted)} of 16 seeds from {2**64 - 15} on land in it" in err
    # So does a search that finds nothing.
    for options, named in (
        (["--bin", 0, "--patience", 1], "none of the 1 seeds from 0 to 0"),
        (["--bin", 9], "bin is 9"),
        (["--bin", 0, "--after", 2**64], str(2**64)),
    ):
        assert named in plinko.refuses("seeds", "triangle-8", *options)


# simulate


def test_simulate_counts_what_drop_many_computes(plinko: Terminal) -> None:
    report = plinko.json("simulate", "triangle-8", "--drops", 300, "--seed", 10)
    many = drop_many(Board.preset("triangle-8"), range(10, 310))
    assert list(report) == [
        "kind", "board", "board_digest", "physics_version", "solver", "seed", "aim", "asked",
        "blocks", "impacts", "duration", "drops", "histogram", "unsettled", "mean_duration",
        "mean_impacts", "digest", "seconds", "drops_per_second", "hashes",
    ]  # fmt: skip
    assert (report["asked"], report["seed"], report["blocks"]) == (300, "10", [[0, 1]])
    assert report["board_digest"] == many.board.digest
    assert report["drops"] == 300
    assert report["histogram"] == many.histogram.tolist()
    assert report["unsettled"] == many.unsettled_count
    assert report["mean_duration"] == pytest.approx(many.duration.mean(), rel=1e-14)
    assert report["mean_impacts"] == many.impact_count.mean()
    assert report["drops_per_second"] == pytest.approx(300 / report["seconds"])
    assert report["digest"] == many.digest
    alone = plinko.json("simulate", "triangle-8", "--drops", 300, "--seed", 10, "--threads", 1)
    timed = {"seconds", "drops_per_second"}
    assert {key: alone[key] for key in alone.keys() - timed} == {
        key: report[key] for key in report.keys() - timed
    }
    out = plinko.run("simulate", "triangle-8", "--drops", 300, "--seed", 10)
    rows = [line.split() for line in out.split("\n\n")[0].splitlines()[1:]]
    assert [int(row[2]) for row in rows] == many.histogram.tolist()
    assert f"{many.score.mean():.3%}" in out
    assert many.digest in out
    last = 2**64 - 1
    report = plinko.json("simulate", "triangle-8", "--drops", 2, "--seed", last - 1)
    assert report["digest"] == drop_many(Board.preset("triangle-8"), [last - 1, last]).digest


# verify


def test_a_record_is_reproduced_a_changed_one_is_not_and_the_field_is_named(
    plinko: Terminal, tmp_path: Path
) -> None:
    path, record = tmp_path / "drop.json", plinko.json("drop", "triangle-8", "--seed", 3)
    path.write_text(json.dumps(record))
    assert plinko.run("verify", path) == f"reproduced: {record['digest']}\n"
    changes: dict[str, object] = {
        "bin": 99, "score": 2.5, "x_end": 0.125, "seed": "4", "digest": "0" * 64,
        "physics_version": 0, "board_digest": "f" * 64, "impacts": [],
    }  # fmt: skip
    for field, value in changes.items():
        path.write_text(json.dumps(record | {field: value}))
        code, out, err = plinko.try_run("verify", path)
        assert (code, err) == (1, "")
        assert out.startswith("not reproduced: ")
        # Another seed gives another drop: the message names the first field that differs.
        assert f"{field} differs" in out or field == "seed"


# boards


def test_boards_are_listed_as_a_table_and_as_json(plinko: Terminal) -> None:
    rows = [line.split() for line in plinko.run("boards").splitlines()[1:]]
    listed = json.loads(plinko.run("boards", "--json"))
    assert [row[0] for row in rows] == [each["name"] for each in listed] == list(preset_names())
    for row, each in zip(rows, listed, strict=True):
        assert each["digest"] == Board.preset(each["name"]).digest
        assert each["digest"].startswith(row[-1])
        assert each["stakes"] == (each["name"] != "galton")
        assert each["top_multiplier"] == max(each["multipliers"])
        if each["stakes"]:
            assert 0.985 <= each["return"] <= 0.995
    assert Counter((each["world"], each["rows"]) for each in listed if each["rows"]) == {
        (world, rows): 3 for world in ("house", *WORLDS) for rows in range(8, 17)
    }


def test_the_help_lists_every_command_once_in_its_group_and_serve_every_setting(
    plinko: Terminal,
) -> None:
    shown = plinko.run("--help")
    assert plinko.run() == plinko.run("-h") == shown
    for title, names in GROUPS.items():
        section = shown.split(f"\n{title}:\n")[1].split("\n\n")[0]
        lines = [line.split() for line in section.splitlines()]
        assert [line[0] for line in lines] == list(names)
        assert all(len(line) > 2 for line in lines)
    for name in COMMANDS:
        assert f"Usage: plinko {name}" in plinko.run(name, "--help")
    assert all(f"  {row.flag} " in plinko.run("serve", "--help") for row in settings.options())


def test_a_printed_board_is_the_board(plinko: Terminal, tmp_path: Path) -> None:
    path = tmp_path / "copy.json"
    path.write_text(plinko.run("boards", "triangle-9"))
    assert Board.from_json(path) == Board.preset("triangle-9")
    assert plinko.json("drop", path, "--seed", 1)["board"] == "triangle-9"


# calibrate


def test_calibrate_searches_and_looks_again_with_new_seeds(plinko: Terminal) -> None:
    few = ("--trials", 4, "--drops", 32, "--check", 100)
    out = plinko.run("calibrate", "--rows", 8, *few, "--json")
    lines = [json.loads(line) for line in out.splitlines()]
    assert [line["what"] for line in lines] == ["better"] * (len(lines) - 1) + ["check"]
    *_, last, check = lines
    assert check["drops"] == 100
    assert all(check[name] == last[name] for name in Tuning._fields)


def test_calibrate_measures_a_preset_as_it_is(plinko: Terminal) -> None:
    out = plinko.run("calibrate", "--rows", 12, "--preset", "--drops", 50, "--json")
    check = json.loads(out)
    assert {name: check[name] for name in Tuning._fields} == TUNING["triangle-12"]._asdict()
    batch = drop_many(Board.preset("triangle-12"), range(UNSEEN, UNSEEN + 50))
    assert check["mean_duration"] == batch.duration.mean()
    assert check["distance"] == fit_of(batch, TUNING["triangle-12"]).distance


# render


def test_render_writes_a_moment_as_a_still(plinko: Terminal, tmp_path: Path) -> None:
    pictures = set()
    for suffix, name in (("PNG", "PNG"), ("jpg", "JPEG"), ("webp", "WEBP")):
        for at in (1.0, 2.0):
            path, size = tmp_path / f"{at}.{suffix}", ("--width", 300)
            out = plinko.run("render", "triangle-8", path, "--seed", 3, "--at", at, *size)
            assert out == f"{path}: {path.stat().st_size:,} bytes\n"
            with Image.open(path) as picture:
                assert (picture.format, getattr(picture, "n_frames", 1)) == (name, 1)
                assert picture.width == 300
                pictures.add(picture.convert("RGB").tobytes())
    assert len(pictures) == 6


def test_render_draws_many_drops(plinko: Terminal, tmp_path: Path, board_file: Path) -> None:
    board = Board.preset("triangle-8")
    path = tmp_path / "many.png"
    plinko.run("render", "triangle-8", path, "--sheet", 4, "--seed", 7, "--columns", 4)
    assert path.read_bytes() == contact_sheet(board, range(7, 11), columns=4)
    plinko.run("render", "triangle-8", path, "--density", 50, "--width", 300, "--theme", "dark")
    assert path.read_bytes() == density_picture(board, range(50), width=300, theme="dark")
    counts = drop_many(board, range(50), solver="stepped").histogram
    plinko.run("render", "triangle-8", path, "--histogram", 50, "--solver", "stepped")
    assert path.read_bytes() == histogram_picture(board, counts)
    jpg = tmp_path / "many.jpg"
    plinko.run("render", board_file, jpg, "--sheet", 2)
    with Image.open(jpg) as picture:
        assert picture.format == "JPEG"


def test_render_writes_an_animation(plinko: Terminal, tmp_path: Path, board_file: Path) -> None:
    duration = drop(Board.from_json(BOARD), 3).duration
    for suffix, name in (("gif", "GIF"), ("webp", "WEBP"), ("apng", "PNG")):
        path = tmp_path / f"drop.{suffix}"
        plinko.run("render", board_file, "--seed", 3, path, "--width", 240, "--fps", 10)
        with Image.open(path) as picture:
            assert picture.format == name
            assert getattr(picture, "n_frames", 1) == int(duration * 10) + 2


# errors

MIDDLE = "0,0,0,0,1,0,0,0,0"
STEPPED = ("drop", "triangle-8", "--seed", "1", "--solver", "stepped")
BAD = [
    # arguments, text that the message must contain
    (("drop", "triangle-8", "--seed", "-1"), "'-1'"),
    (("drop", "triangle-8", "--seed", 2**64), str(2**64)),
    (("drop", "triangle-8", "--seed", "abc"), "'abc'"),
    (("drop", "triangle-8", "--seed", "1.5"), "'1.5'"),
    (("drop", "triangle-8", "--seed", ""), "''"),
    (("drop", "triangle-8"), "--seed N or --x X"),
    (("drop", "triangle-8", "--seed", "1", "--x", "nan"), "nan"),
    (("drop", "triangle-8", "--seed", "1", "--x", "inf"), "inf"),
    (("drop", "triangle-8", "--seed", "1", "--x", "-99"), "-99"),
    (("drop", "triangle-8", "--seed", "1", "--x", "left"), "'left'"),
    (("drop", "triangle-8", "--seed", "1", "--dt", "0.25"), "--dt 0.25"),
    (("drop", "triangle-8", "--seed", "1", "--substeps", "4"), "--substeps 4"),
    (("drop", "triangle-8", "--seed", "1", "--solver", "magic"), "'magic'"),
    ((*STEPPED, "--dt", "1/0"), "'1/0'"),
    ((*STEPPED, "--dt", "soon"), "'soon'"),
    ((*STEPPED, "--dt", "-1"), "-1"),
    ((*STEPPED, "--dt", "nan"), "nan"),
    ((*STEPPED, "--substeps", "0"), "substeps 0"),
    (("drop", "triangle-99", "--seed", "1"), "'triangle-99'"),
    (("drop", "", "--seed", "1"), "''"),
    (("drop", "{tmp}", "--seed", "1"), "{tmp}"),
    (("drop", "{tmp}/broken.json", "--seed", "1"), "JSON"),
    (("drop", "{tmp}/deep.json", "--seed", "1"), "deep"),
    (("drop", "{tmp}/binary.json", "--seed", "1"), "binary.json"),
    (("drop", "{tmp}/narrow.json", "--seed", "1"), "cannot pass"),
    (("drop", "triangle-8", "--seed", "1", "--bogus"), "--bogus"),
    (("drop", "triangle-8", "more", "--seed", "1"), "more"),
    (("simulate", "triangle-8", "--drops", "0"), "0"),
    (("simulate", "triangle-8", "--drops", "2", "--seed", 2**64 - 1), str(2**64)),
    (("simulate", "triangle-8", "--drops", "many"), "'many'"),
    (("simulate", "triangle-8", "--drops", "2", "--threads", "0"), "0"),
    (("render", "triangle-8", "--seed", "1", "{tmp}/drop.bmp"), "drop.bmp"),
    (("render", "triangle-8", "--seed", "1", "{tmp}/none/drop.png"), "none"),
    (("render", "triangle-8", "--seed", "1", "{tmp}/drop.png", "--width", "9"), "width 9"),
    *(
        (("render", "triangle-8", "{tmp}/drop.png", *kind, "--width", width), f"width {width}")
        for kind in (("--seed", "1"), ("--sheet", "4"), ("--density", "9"), ("--histogram", "9"))
        for width in ("0", "-1")
    ),
    (("render", "triangle-8", "{tmp}/drop.gif", "--seed", "1", "--width", "0"), "width 0"),
    (("render", "triangle-8", "{tmp}/a.png", "--sheet", "4", "--columns", "0"), "columns 0"),
    (("render", "triangle-8", "--seed", "1", "{tmp}/drop.gif", "--fps", "0"), "fps 0"),
    (("map", "triangle-8", "{tmp}/map.png", "--x", "99"), "x '99' is not a start"),
    (("map", "triangle-8", "{tmp}/map.png", "--x", "-4/3"), "x '-4/3' is not a start"),
    (("map", "triangle-8", "{tmp}/none/map.png", "--levels", "1", "--pixels", "2"), "{tmp}/none"),
    (("seeds", "triangle-8", "--bin", "4", "--after", 2**64 - 1), "only 0 of 1 seeds"),
    (("seeds", "triangle-8", "--bin", "4", "--after", 2**64 - 9, "--json", "--count", "9"), "2^64"),
    (("seeds", "triangle-8", "--draw", "{tmp}/list.json", "--after", 2**64 - 1), "a list of 9"),
    (("seeds", "triangle-8", "--draw", MIDDLE, "--after", 2**64 - 9), "no further seed up to the"),
    (("seeds", "triangle-8", "--draw", "9" * 5000), "--draw"),
    (("render", "triangle-8", "--seed", "1", "{tmp}/drop.gif", "--at", "1"), "drop.gif"),
    (("render", "triangle-8", "--seed", "1", "{tmp}/drop.png", "--at", "-1"), "-1"),
    (("render", "triangle-8", "--seed", "1", "{tmp}/drop.png", "--theme", "pink"), "'pink'"),
    (("render", "triangle-8", "{tmp}/drop.png"), "--seed"),
    (("render", "triangle-8", "{tmp}/drop.gif", "--sheet", "4"), "drop.gif"),
    (("render", "triangle-8", "{tmp}/a.png", "--sheet", "0"), "--sheet 0"),
    (("render", "triangle-8", "{tmp}/a.png", "--sheet", "999"), "999"),
    (("render", "triangle-8", "{tmp}/a.png", "--density", "-3"), "--density -3"),
    (("render", "triangle-8", "{tmp}/a.png", "--density", "2", "--sheet", "4"), "--sheet 4"),
    (("render", "triangle-8", "{tmp}/a.png", "--density", "2", "--at", "1"), "--at 1"),
    (("render", "triangle-8", "{tmp}/a.png", "--density", "2", "--columns", "3"), "--columns 3"),
    (("render", "triangle-8", "{tmp}/a.png", "--seed", "1", "--columns", "3"), "--columns 3"),
    (("render", "triangle-8", "{tmp}/a.png", "--sheet", "2", "--solver", "stepped"), "stepped"),
    (("render", "triangle-8", "{tmp}/a.png", "--histogram", "2", "--seed", 2**64 - 1), str(2**64)),
    (("verify", "{tmp}/none.json"), "none.json"),
    (("verify", "{tmp}"), "{tmp}"),
    (("verify", "{tmp}/broken.json"), "broken.json"),
    (("verify", "{tmp}/deep.json"), "deep.json"),
    (("verify", "{tmp}/binary.json"), "binary.json"),
    (("verify", "{tmp}/list.json"), "[1, 2]"),
    (("verify", "{tmp}/empty.json"), "'board'"),
    (("boards", "nope"), "'nope'"),
    (("serve", "--port", "99999"), "99999"),
    (("serve", "--port", "x"), "'x'"),
    (("serve", "--board", "nope"), "nope"),
    (("frobnicate",), "'frobnicate'"),
    (("--frob",), "--frob"),
]


@pytest.fixture
def bad_files(tmp_path: Path) -> Path:
    (tmp_path / "broken.json").write_text('{"name": "x"')
    (tmp_path / "deep.json").write_text("[" * 100_000)
    (tmp_path / "binary.json").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "list.json").write_text("[1, 2]")
    (tmp_path / "empty.json").write_text("{}")
    pegs = [{"x": x / 10, "y": 1.0, "radius": 0.03} for x in range(-15, 16)]
    (tmp_path / "narrow.json").write_text(json.dumps(BOARD | {"pegs": pegs}))
    return tmp_path


@pytest.mark.parametrize(("arguments", "named"), BAD)
def test_bad_input_is_one_line_that_names_it(
    plinko: Terminal, bad_files: Path, arguments: tuple[str, ...], named: str
) -> None:
    filled = [str(argument).replace("{tmp}", str(bad_files)) for argument in arguments]
    assert named.replace("{tmp}", str(bad_files)) in plinko.refuses(*filled)


def test_garbage_waits_while_a_short_command_runs_and_no_longer(plinko: Terminal) -> None:
    assert gc.isenabled()
    assert garbage_waits()(gc.isenabled)() is False
    assert gc.isenabled()
    plinko.run("drop", "triangle-8", "--seed", 1)
    assert gc.isenabled()
    assert plinko.try_run("drop", "triangle-8", "--seed", -1)[0] == 2
    assert gc.isenabled()
