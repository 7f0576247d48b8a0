"""The page's solver compared with the engine: boards, arrays, digests, states, errors."""

import json
import math
from typing import Any

import numpy as np
import pytest

from plinko.engine import Board, BoardError, drop
from tests.engine.artifact.drops import cases
from tests.engine.board.forms import EXAMPLE, changed
from tests.js.conftest import Run
from tests.long import tries
from tools.boards.hard_boards import KINDS, hard_board
from tools.boards.wall_boards import seeds_of, wall_board

_OPEN = """
const { readFileSync } = await import("node:fs");
const bytes = readFileSync(new URL("solver/kernels.wasm", MODULES_URL));
const solver = await openSolver(bytes);
"""


def opened(body: str) -> str:
    """A JavaScript function with this body, in which `solver` is an open solver."""
    from tests.js.conftest import MODULES

    start = _OPEN.replace("MODULES_URL", json.dumps(f"{MODULES.as_uri()}/"))
    return f"async ({{ openSolver }}, given) => {{ {start} {body} }}"


@pytest.mark.long
def test_a_page_computes_every_drop_to_the_engine_s_last_bit(run: Run) -> None:
    expected = cases()
    given = [{"board": each["board"], "seeds": len(each["digests"])} for each in expected]
    found = run(
        "solver/solver.js",
        opened("""return given.map(({ board, seeds }) => {
          const drops = Array.from({ length: seeds }, (_, seed) => solver.drop(board, { seed }));
          return { board_digest: drops[0].boardDigest, digests: drops.map((d) => d.digest) };
        });"""),
        given,
    )
    for mine, true in zip(found, expected, strict=True):
        name = true["board"]["name"]
        assert mine["board_digest"] == true["board_digest"], name
        wrong = [s for s, d in enumerate(true["digests"]) if mine["digests"][s] != d]
        assert not wrong, f"{name}: seeds {wrong[:5]}"


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
def test_a_page_computes_hard_boards_to_the_engine_s_last_bit(run: Run, kind: str) -> None:
    made = [hard_board(kind, number) for number in range(tries(4, 200))]
    boards = [(hard, board) for hard in made if (board := hard.playable()) is not None]
    seeds = range(tries(5, 50))
    found = run(
        "solver/solver.js",
        opened("""return given.map(({ board, starts }) =>
          starts.map((start) => solver.drop(board, start).digest));"""),
        [
            {
                "board": board.to_dict(),
                "starts": [*({"seed": seed} for seed in seeds), *({"x": x} for x in hard.starts)],
            }
            for hard, board in boards
        ],
    )
    for (hard, board), digests in zip(boards, found, strict=True):
        drops = [*(drop(board, seed) for seed in seeds), *(drop(board, x=x) for x in hard.starts)]
        assert digests == [each.digest for each in drops], hard.form


@pytest.mark.long
def test_a_page_computes_walls_in_pieces_to_the_engine_s_last_bit(run: Run) -> None:
    numbers = range(tries(40, 2000))
    boards = [wall_board(number) for number in numbers]
    seeds = [seeds_of(number, tries(4, 20)) for number in numbers]
    found = run(
        "solver/solver.js",
        opened("""return given.map(({ board, seeds }) =>
          seeds.map((seed) => solver.drop(board, { seed }).digest));"""),
        [
            {"board": board.to_dict(), "seeds": list(each)}
            for board, each in zip(boards, seeds, strict=True)
        ],
    )
    for board, each, digests in zip(boards, seeds, found, strict=True):
        assert digests == [drop(board, seed).digest for seed in each], board.name


def test_states_at_any_time_and_the_record_are_the_engine_s(run: Run) -> None:
    board = Board.preset("triangle-16")
    aside = board.drop.x + 0.01
    drops = [drop(board, 2**64 - 1), drop(board, x=aside), drop(board, 7, aim=aside)]
    asked: list[dict[str, Any]] = []
    for each in drops:
        times = [*np.linspace(0.0, each.duration + 1.0, 300), *each.impacts["t"].tolist()]
        seed = None if each.seed is None else str(each.seed)
        x = each.x_start if each.explicit_x else None
        start = {"seed": seed, "x": x, "aim": each.aim}
        asked.append({"board": board.to_dict(), "start": start, "times": times})
    found = run(
        "solver/solver.js",
        opened("""return given.map(({ board, start, times }) => {
          const drop = solver.drop(board, start);
          return { record: drop.record(), states: drop.states(times) };
        });"""),
        asked,
    )
    for each, request, mine in zip(drops, asked, found, strict=True):
        record = each.to_dict()
        assert mine["record"] | {"board": board.name} == record
        for true, got in zip(each.states(request["times"]), mine["states"], strict=True):
            assert got == {name: float(true[name]) for name in got}, got["t"]


WRONG: list[tuple[tuple[str | int, ...], Any]] = [
    (("gravity",), 0),
    (("gravity",), "9.81"),
    (("drag",), -1),
    (("name",), ""),
    (("name",), "a\nb"),
    (("width",), None),
    (("ball", "radius"), 0),
    (("ball", "friction"), 11),
    (("ball", "colour"), "red"),
    (("pegs",), {}),
    (("pegs", 0), {"x": 1.0, "y": 1.0}),
    (("pegs", 0, "radius"), -0.1),
    (("walls", 0, "x2"), 1e7),
    (("walls", 0), {"x1": 0.0, "y1": 0.0, "x2": 0.0, "y2": 0.0}),
    (("peg_material", "restitution"), 1.5),
    (("bins", "edges"), [0.0]),
    (("bins", "edges"), [0.0, 1.0, 1.0]),
    (("bins", "multipliers"), [1.0]),
    (("bins", "labels"), [None]),
    (("bins", "labels"), ["T-shirt", None]),
    (("bins", "labels"), [{}, None]),
    (("bins", "labels"), [{"text": ""}, None]),
    (("bins", "labels"), [{"text": "x" * 41}, None]),
    (("bins", "labels"), [{"text": " x"}, None]),
    (("bins", "labels"), [{"text": "a\nb"}, None]),
    (("bins", "labels"), [None, {"text": "a\u202eb"}]),
    (("bins", "labels"), [None, {"text": "x\u0301\u0302\u0303"}]),
    (("bins", "labels"), [None, {"text": "\u3164"}]),
    (("bins", "labels"), [None, {"text": "x", "colour": "#FF0000"}]),
    (("bins", "labels"), [None, {"text": "x", "prize": 1}]),
    (("drop", "jitter"), -1),
    (("drop", "slots"), ["0"]),
    (("colour",), "red"),
]


def test_a_board_with_a_wrong_value_is_refused_by_name(run: Run) -> None:
    boards = [changed(EXAMPLE, path, value) for path, value in WRONG]
    fields = run(
        "solver/input/values.js",
        """({ readBoard }, boards) => boards.map((board) => {
          try { readBoard(board); return null; } catch (error) { return error.field; }
        })""",
        boards,
    )
    for board, field in zip(boards, fields, strict=True):
        with pytest.raises(BoardError) as caught:
            Board.from_json(board)
        assert field == caught.value.field


def test_labels_are_read_and_hashed_as_in_the_engine(run: Run) -> None:
    labels = [None, {"text": "Cafe\u0301 \U0001f381", "colour": "#ff0088"}]
    forms = [changed(EXAMPLE, ("bins", "labels"), each) for each in (labels, [None, None])]
    forms.append(changed(forms[0], ("drop", "reach"), 0.5))
    found = run(
        "solver/solver.js",
        opened("""return given.map((board) => {
          const drop = solver.drop(board, { seed: 7 });
          return { digest: drop.boardDigest, record: drop.record() };
        });"""),
        forms,
    )
    for form, mine in zip(forms, found, strict=True):
        board = Board.from_json(form)
        assert mine["digest"] == board.digest
        record = drop(board, 7).to_dict()
        assert mine["record"]["digest"] == record["digest"]
        assert mine["record"].get("label") == record.get("label")
        assert mine["record"]["board"]["bins"] == board.to_dict()["bins"]
    assert {mine["record"].get("label") for mine in found} == {"Caf\xe9 \U0001f381", None}


def test_omitted_parts_have_the_engine_s_defaults(run: Run) -> None:
    bare = {
        "bins": {"multipliers": [1, 2, 1]},
        "drop": {"x": -0.0},
        "pegs": [{"x": 0, "y": 1, "radius": 0.1}],
    }
    filled = run("solver/input/values.js", "({ readBoard }, board) => readBoard(board)", bare)
    true = Board.from_json(bare).to_dict()
    true["drop"] |= {"slots": [], "reach": 0.0, "aim": 0.0}
    assert filled == true
    assert math.copysign(1.0, filled["drop"]["x"]) == 1.0
