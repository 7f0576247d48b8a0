"""Every file in examples/ runs as its first lines say, and does what they say."""

import ast
import csv
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from PIL import Image

from plinko.app.fairness.signing import Signer
from plinko.engine import Board, drop, find_draw
from tests.app.conftest import TINY
from tests.kit.serving import Running, serving
from tests.kit.waiting import LIMIT
from tests.repository.test_repository import ROOT

EXAMPLES = ROOT / "examples"
GOLDEN = ROOT / "tests" / "golden" / "session.json"
DRAWN = GOLDEN.with_name("draw_session.json")


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    """A server in whose room `main` balls land within a second."""
    board = tmp_path_factory.mktemp("board") / "tiny.json"
    board.write_text(json.dumps(TINY))
    with serving(board=str(board)) as running:
        yield running


def run(*command: object, code: int = 0, given: str = "") -> str:
    done = subprocess.run(
        [str(part) for part in command],
        cwd=EXAMPLES,
        input=given,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == code, done.stderr
    return done.stdout


def node(*command: object) -> str:
    folder = subprocess.run([ROOT / "tools" / "node"], capture_output=True, text=True, check=True)
    program = Path(folder.stdout.strip()) / "node"
    return run(program, "--experimental-websocket", *command)


def test_every_example_has_a_test_and_says_how_it_is_run() -> None:
    text = Path(__file__).read_text("utf-8")
    names = [path.name for path in EXAMPLES.iterdir() if path.suffix in {".py", ".mjs"}]
    assert len(names) >= 7
    for name in names:
        assert f'"{name}"' in text
        assert name in (EXAMPLES / name).read_text("utf-8").split("import", 1)[0]


@pytest.mark.parametrize(
    ("program", "name"),
    [(lambda *c: run(sys.executable, *c), "rest_client.py"), (node, "rest-client.mjs")],
)
def test_a_rest_client_replays_verifies_and_plays(
    server: Running, program: Callable[..., str], name: str
) -> None:
    said = program(name, server.url)
    assert "seed 42 lands in bin 3 and pays 5" in said
    assert "reproduced: " in said
    assert "seed 7 landed in bin " in said


def test_a_websocket_client_follows_its_ball_in_three_streams(server: Running) -> None:
    said = run(sys.executable, "websocket_client.py", server.url.replace("http", "ws", 1))
    snapshots, places, paths, drawn, seeds, digest = said.splitlines()
    assert re.match(r"snapshots: \d+ binary messages, then {'type': 'landed', ", snapshots)
    assert len(json.loads(places)) >= 2
    assert all(0.0 < x < 1.0 for x in json.loads(places))
    assert re.match(r"paths: [12] binary messages, then {'type': 'landed', ", paths)
    seed = re.search(r"'seed': '(\d+)'", paths)
    assert seed
    board = Board.from_json(TINY)
    shown = np.array(ast.literal_eval(drawn))
    true = drop(board, int(seed[1])).states(np.arange(len(shown)) / 10)
    assert len(shown) > 3
    assert np.hypot(shown[:, 0] - true["x"], shown[:, 1] - true["y"]).max() < 0.15e-3
    assert seeds.startswith("seeds: 0 binary messages, then {'type': 'landed', ")
    assert f"'digest': '{digest[:12]}'" in seeds


def test_a_websocket_client_in_javascript_does_so_too(server: Running) -> None:
    said = node("websocket-client.mjs", server.url.replace("http", "ws", 1))
    assert re.findall(r'(\w+): {"type":"landed"', said) == ["snapshots", "paths", "seeds"]
    assert re.search(r"last seen: \[\s*{ ball: \d+, x: -?\d", said)
    end = re.search(r'paths: .*"x_end":([-.\de]+)', said)
    seen = re.search(r"last seen: { x: ([-.\de]+), y: ([-.\de]+) }", said)
    assert end
    assert seen
    assert float(seen[1]) == pytest.approx(float(end[1]), abs=1e-6)
    assert float(seen[2]) == pytest.approx(Board.from_json(TINY).bins.y, abs=1e-6)


def test_the_determinism_test_has_the_digests_of_this_release() -> None:
    said = run(
        sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_determinism.py"
    )
    assert "3 passed" in said
    text = (EXAMPLES / "test_determinism.py").read_text("utf-8")
    assert all(line in text for line in run(sys.executable, "test_determinism.py").splitlines())


def test_a_worksheet_has_its_pictures_table_and_questions(tmp_path: Path) -> None:
    lesson = tmp_path / "lesson"
    said = run(sys.executable, "worksheet.py", lesson)
    assert "bin  6" in said
    with Image.open(lesson / "histogram.png") as picture:
        assert picture.format == "PNG"
    with Image.open(lesson / "fall.gif") as film:
        assert getattr(film, "n_frames", 1) > 10
    with open(lesson / "drops.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 2000
    assert {"seed", "bin", "impact_count"} <= set(rows[0])


def test_an_environment_rewards_starts_above_the_goal() -> None:
    said = run(sys.executable, "vector_env.py").splitlines()
    above, anywhere = (float(line.rpartition(" ")[2]) for line in said)
    assert anywhere < above < 0.0


def test_an_environment_has_the_form_of_gymnasium(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(EXAMPLES)
    env = import_module("vector_env").PlinkoVectorEnv("classic", num_envs=5)
    first, info = env.reset(seed=3)
    assert (first.shape, first.dtype, info) == ((5, 1), np.float32, {})
    assert np.array_equal(env.reset(seed=3)[0], first)
    xs = np.array([[-1.0], [0.0], [0.5], [1.0], [99.0]], np.float32)
    following, rewards, terminated, truncated, info = env.step(xs)
    drops = [drop("classic", x=min(float(x), env.high)) for x in xs.ravel()]
    landed = [-1 if each.bin is None else each.bin for each in drops]
    assert info["bin"].tolist() == landed
    assert rewards.tolist() == (-np.abs(np.array(landed) - first.ravel())).tolist()
    assert truncated.tolist() == [False, True, False, False, False], "in balance on a peg"
    assert (terminated == ~truncated).all()
    assert np.array_equal(info["final_obs"], first)
    assert following.shape == (5, 1)


def test_a_draw_is_held_as_the_page_about_the_stage_says(server: Running, tmp_path: Path) -> None:
    page = (ROOT / "docs" / "stage.md").read_text("utf-8")
    section = page.partition("## A draw with exact odds")[2]
    find, hold, verify = section.partition("```bash\n")[2].partition("```")[0].splitlines()
    assert hold.startswith("python hold_draw.py draw.json session.json Ada Bob")
    assert all(line in (EXAMPLES / "hold_draw.py").read_text("utf-8") for line in (find, hold))
    places = {name: str(tmp_path / name) for name in ("draw.json", "session.json")}

    def words(line: str) -> list[str]:
        return [places.get(word, word) for word in line.split()[1:]]

    assert "200 seeds, ready for POST rooms" in run(sys.executable, "-m", "plinko", *words(find))
    # On a fast board: the drops that the command has written for the preset take seconds.
    draw = {"board": TINY, "mode": "draw", "draw": find_draw(Board.from_json(TINY), [1, 9999])}
    Path(places["draw.json"]).write_text(json.dumps(draw))
    told = run(sys.executable, *words(hold), "--server", server.url, given="\n")
    assert re.search(r"room \w+, draw [0-9a-f]{64}\nthe server has committed to [0-9a-f]{64}", told)
    assert re.search(r"Ada: bin [12]\nBob: bin [12]\n", told)
    said = run(sys.executable, "-m", "plinko", *words(verify))
    assert "proven: 2 drops" in said
    assert "proven: the server had committed before" in said
    export = json.loads(Path(places["session.json"]).read_text())
    room = export["session"]["statement"]["room"]
    drops = httpx.get(f"{server.url}/api/v1/rooms/{room}/log", timeout=LIMIT).json()["drops"]
    assert [each["name"] for each in drops] == ["Ada", "Bob"]


def session_of(text: str = GOLDEN.read_text("utf-8")) -> Any:
    return json.loads(text)


@pytest.fixture
def check(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> Callable[[Any], list[str]]:
    """Verifies a session, or a file's bytes, in this process; returns the lines it prints."""
    monkeypatch.syspath_prepend(EXAMPLES)
    main = import_module("verify_session").main

    def lines(session: Any) -> list[str]:
        raw = session if isinstance(session, bytes) else json.dumps(session).encode()
        (tmp_path / "session.json").write_bytes(raw)
        failed = main(str(tmp_path / "session.json"))
        printed = capsys.readouterr().out.splitlines()
        assert failed == any(line.startswith("does not hold: ") for line in printed)
        return printed

    return lines


Check = Callable[[Any], list[str]]


def test_an_honest_session_is_verified(check: Check) -> None:
    session = session_of()
    said = f"all of it holds: 4 drops, key {session['key']}"
    assert run(sys.executable, "verify_session.py", GOLDEN) == f"{said}\n"
    told = run(sys.executable, "verify_session.py", GOLDEN, "0" * 64, code=1)
    assert "the key is the one that you know" in told
    assert check(GOLDEN.read_text("utf-8").encode("utf-16")) == [said]


@pytest.mark.parametrize(
    ("place", "value", "claim"),
    [
        (("server_seed",), "11" * 32, "the server's seed is the one it committed to"),
        (("client_seed",), "11" * 32, "your seed is the one you committed to"),
        (("drops", 1, "receipt", "seed"), "5", "drop 1: both seeds draw its start"),
        (("drops", 1, "receipt", "stake"), 7, "drop 1: the receipt is signed"),
        (("drops", 2, "index"), 0, "drop 2: the log has it"),
        (("drops", 3, "result", "payout"), 10**6, "drop 3: its payout"),
        (("drops", 3, "result", "digest"), "0" * 64, "drop 3: every bit of its path"),
        (("head", "statement", "size"), 14, "the head of the log is signed"),
        (("end", "statement", "drops"), 3, "no drop is left out"),
        (("session", "statement", "time"), 1, "the statement is signed"),
        (("board", "bins", "multipliers", 0), 99.0, "the multipliers are those committed to"),
        (("key",), Signer(bytes(32)).public.hex(), "the statement is signed"),
    ],
)
def test_whatever_is_forged_is_named(
    check: Check, place: tuple[Any, ...], value: object, claim: str
) -> None:
    session = session_of()
    part = session
    for step in place[:-1]:
        part = part[step]
    assert part[place[-1]] != value
    part[place[-1]] = value
    assert f"does not hold: {claim}" in check(session)


def test_a_drop_left_out_and_a_stake_that_could_pay_too_much_are_named(check: Check) -> None:
    session = session_of()
    del session["drops"][2]
    assert "does not hold: no drop is left out" in check(session)
    session = session_of()
    session["board"]["bins"]["multipliers"][0] = 1e9
    session["drops"][1]["receipt"]["stake"] = 10**9
    assert "does not hold: drop 1: all it could pay is below 2^53" in check(session)


def test_a_member_given_twice_is_refused(check: Check, tmp_path: Path) -> None:
    twice = GOLDEN.read_text("utf-8").replace('"version"', '"kind": "x", "version"', 1)
    with pytest.raises(SystemExit, match="'kind': the key is given twice"):
        check(twice.encode())
    path = tmp_path / "draw.json"
    path.write_text('{"board": "triangle-8", "board": "classic"}')
    files = str(EXAMPLES / "hold_draw.py"), str(path), str(tmp_path / "session.json")
    command = [sys.executable, *files, "Ada"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (1, "'board': the key is given twice\n")


def test_a_draw_s_session_is_verified_and_any_forgery_named(check: Check) -> None:
    text = DRAWN.read_text("utf-8")
    (said,) = check(session_of(text))
    assert said.startswith("all of it holds: 6 drops, ")
    lighter, steered = session_of(text), session_of(text)
    lighter["draw"]["weights"][0] -= 1
    assert "does not hold: the draw is the one committed to" in check(lighter)
    steered["drops"][0]["receipt"]["seed"] = "1"
    steered["drops"][1]["result"]["bin"] = 2
    told = check(steered)
    assert "does not hold: drop 0: its ball is of that bin's list" in told
    assert "does not hold: drop 1: both seeds draw its bin" in told


def test_the_prize_board_falls_as_its_preset_and_names_prizes() -> None:
    board, plain = Board.from_json(EXAMPLES / "prizes.json"), Board.preset("triangle-8")
    prize, bare = drop(board, 42), drop(plain, 42)
    assert prize.impacts.tobytes() == bare.impacts.tobytes()
    assert board.bins.label_of(0) == "Concert tickets"
    assert prize.label == board.bins.label_of(bare.bin)
