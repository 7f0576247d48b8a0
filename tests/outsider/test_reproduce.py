"""The files next to docs/reproduce.md are a complete solver with the engine's digests."""

import json
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from benchmarks.scenes.contact_scenes import scene, scene_names
from benchmarks.scenes.random_boards import random_board
from plinko.engine import Board, drop, drop_many
from tests.engine.batches.open_board import DROPS, OPEN
from tests.kit.presets import SAMPLE
from tests.long import tries
from tools.boards.hard_boards import KINDS, hard_board
from tools.boards.wall_boards import wall_board

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "reproduce.md").read_text(encoding="utf-8")
FILES = [path.read_text(encoding="utf-8") for path in sorted(DOCS.glob("reproduce_*.py"))]


@cache
def solver() -> dict[str, Any]:
    """The names that the page's files define."""
    names: dict[str, Any] = {}
    for text in FILES:
        exec(text, names)
    return names


def redo(board: Board, seed: int, x: float | None) -> tuple[str, list[Any]]:
    """Digest and events of a drop, computed only by the page's code, also the board's digest."""
    page, form = solver(), board.to_dict()
    x = page["start_x"](seed, form["drop"]) if x is None else x
    y = form["drop"]["y"]
    _, events, outcome = page["drop"](page["Board"](form), x, y)
    return page["digest"](board.digest, x, y, events, outcome), events


def compare(board: Board, seeds: int, x: float | None = None) -> None:
    for seed in range(seeds):
        expected = drop(board, seed, x=x)
        found, events = redo(board, seed, x)
        rows = [(*state, kind, index) for state, kind, index in events]
        assert rows == [tuple(row) for row in expected.to_dict()["impacts"]], (board.name, seed)
        assert found == expected.digest, (board.name, seed)


def test_the_page_starts_drops_about_an_aim() -> None:
    board = Board.preset("triangle-9")
    for seed, aim in [(0, board.drop.aim_span), (7, -0.5 * board.drop.aim_span), (8, 0.0)]:
        x = solver()["start_x"](seed, board.to_dict()["drop"], aim)
        assert x == drop(board, seed, aim=aim).x_start


@pytest.mark.long
@pytest.mark.parametrize("name", ["triangle-8", "classic", "galton", *tries([], SAMPLE)])
def test_the_page_gives_the_digests_of_presets(name: str) -> None:
    compare(Board.preset(name), tries(1, 20))


@pytest.mark.long
@pytest.mark.parametrize("name", scene_names())
def test_the_page_rolls_and_slides_as_the_engine_does(name: str) -> None:
    shown = scene(name)
    compare(shown.board, tries(1, 10), shown.x)


@pytest.mark.long
def test_the_page_gives_the_digests_of_random_boards() -> None:
    for number in range(tries(6, 60)):
        compare(random_board(number), tries(1, 3))


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
def test_the_page_gives_the_digests_of_drops_on_hard_boards(kind: str) -> None:
    for number in range(tries(2, 12)):
        hard = hard_board(kind, number)
        board = hard.playable()
        if board is None:
            continue
        compare(board, tries(1, 4))
        for x in hard.starts[: tries(1, 5)]:
            compare(board, 1, x)


@pytest.mark.long
@pytest.mark.parametrize("group", range(tries(3, 40)))
def test_the_page_gives_the_digests_of_drops_on_walls_in_pieces(group: int) -> None:
    for number in range(10 * group, 10 * group + tries(6, 10)):
        compare(wall_board(number), tries(2, 10))


def worked() -> str:
    """The page's worked example, as the page's code computes it."""
    page, board = solver(), Board.preset("triangle-8")
    form = board.to_dict()
    layout, x, y = page["Board"](form), page["start_x"](42, form["drop"]), form["drop"]["y"]
    rise = page["length_bound"](0.0, layout.gravity)
    speed = layout.travel / layout.fall + 0.5 * layout.fall * rise
    s, number, _ = page["next_impact"](layout, x, y, 0.0, 0.0, None, 0.0, None, None, 1000.0)
    _, events, outcome = page["drop"](layout, x, y)
    told: dict[str, object] = {
        "board's digest": board.digest,
        "start": f"{x} {y}",
        "travel, fall": f"{layout.travel} {layout.fall}",
        "first window": 2.0 * layout.travel / page["length_bound"](0.0, speed),
        "surface hit": number,
        "after": s,
        "decay": page["basis"](layout.drag, s)[0],
        "phi, psi": "{1} {2}".format(*page["basis"](layout.drag, s)),
    }
    for i in (0, 1, 2, len(events) - 1):
        state, kind, index = events[i]
        told[f"event {i}"] = " ".join(map(str, (*state, kind, index)))
    told |= {"events": len(events), "outcome": outcome}
    told["digest"] = page["digest"](board.digest, x, y, events, outcome)
    return "".join(f"{name:<16}{value}\n" for name, value in told.items())


def test_the_worked_drop_is_what_the_page_computes() -> None:
    assert f"```text\n{worked()}```\n" in PAGE
    assert f"digest          {drop('triangle-8', 42).digest}\n" in PAGE


def test_the_files_are_a_program(tmp_path: Path) -> None:
    board, found = Board.preset("triangle-8"), drop("triangle-8", 42)
    for name, value in (("board", board), ("record", found)):
        (tmp_path / name).write_text(json.dumps(value.to_dict()))
    command = [sys.executable, str(DOCS / "reproduce_drop.py"), "board", "record"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout == f"computed {found.digest}\nrecorded {found.digest}\n"


def test_the_page_gives_the_digest_of_a_batch() -> None:
    page, many = solver(), drop_many(OPEN, range(DROPS))
    columns = (many.bin, many.duration, many.impact_count, many.x_end)
    rows = list(zip(*(each.tolist() for each in columns), strict=True))
    blocks = [rows[k : k + 65_536] for k in range(0, DROPS, 65_536)]
    hashes = [page["block_hash"](OPEN.digest, each) for each in blocks]
    assert page["batch_digest"](hashes).hex() == many.digest
