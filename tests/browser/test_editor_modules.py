"""The editor's model of a board: what may change, what is found where, what a refusal is about."""

import json
from functools import partial
from typing import Any

import pytest
from playwright.sync_api import Error

from engine import Board
from tests.browser.conftest import Run


@pytest.fixture
def draft(run: Run) -> Run:
    """Calls a JavaScript function with the module draft.js and an argument."""
    return partial(run, "editor/draft.js")


BOARD = Board.preset("triangle-8").to_dict()


def test_a_small_board_to_start_with_can_be_played(draft: Run) -> None:
    assert Board.from_json(draft("({ EMPTY }) => EMPTY")).bins.count == 3


def test_what_a_file_leaves_out_is_filled_in_as_the_server_does(draft: Run) -> None:
    forms: list[dict[str, Any]] = [
        {},
        {"bins": {"multipliers": [1, 2, 3]}},
        {"width": 4, "height": 2, "bins": {"edges": [-2, 2]}},
        {"ball": {"radius": 0.1}, "drop": {"y": 0.5}, "name": "short"},
        BOARD,
    ]
    for form in forms:
        assert draft("({ complete }, form) => complete(form)", form) == (
            Board.from_json(form).to_dict()
        )


@pytest.mark.parametrize(
    ("form", "named"),
    [
        ([], "object"),
        ({"pegs": 3}, "pegs"),
        ({"pegs": [{"x": 1, "y": "two", "radius": 0.1}]}, "not a number"),
        ({"bins": {"edges": [0, 1, 0.5], "multipliers": [1, 1]}}, "rise"),
        ({"bins": {"edges": [0, 1], "multipliers": [1, 1]}}, "one multiplier"),
    ],
)
def test_what_cannot_be_drawn_is_refused_in_words(draft: Run, form: Any, named: str) -> None:
    with pytest.raises(Error, match=named):
        draft("({ complete }, form) => complete(form)", form)


def test_edges_never_pass_each_other(draft: Run) -> None:
    script = "({ moved }, [board, x]) => moved(board, { kind: 'edge', index: 3 }, x, 0).bins.edges"
    for x in (-100.0, 100.0):
        edges = draft(script, [BOARD, x])
        assert edges == sorted(edges)
        assert len(set(edges)) == len(edges)
        Board.from_json({**BOARD, "bins": {**BOARD["bins"], "edges": edges}})


def test_a_bin_is_divided_and_joined_again(draft: Run) -> None:
    middle = (BOARD["bins"]["edges"][2] + BOARD["bins"]["edges"][3]) / 2
    split, back = draft(
        """({ withSplit, without }, [board, x]) => {
          const made = withSplit(board, x);
          return [made, without(made.board, made.ref)];
        }""",
        [BOARD, middle],
    )
    assert split["ref"] == {"kind": "edge", "index": 3}
    assert split["board"]["bins"]["edges"][3] == middle
    pays = BOARD["bins"]["multipliers"]
    assert split["board"]["bins"]["multipliers"] == [*pays[:3], pays[2], *pays[3:]]
    assert back == BOARD


def test_bins_keep_one_multiplier_each_whatever_is_taken_away(draft: Run) -> None:
    """Any edge, any bin, until one bin is left, which stays."""
    left = draft(
        """({ without, refsOf }, board) => {
          const seen = [];
          for (let turn = 0; turn < 50; turn += 1) {
            const refs = refsOf(board).filter(({ kind }) => kind === "edge" || kind === "bin");
            const next = without(board, refs[(turn * 7) % refs.length]);
            if (!next) break;
            board = next;
            seen.push([board.bins.edges, board.bins.multipliers]);
          }
          return seen;
        }""",
        BOARD,
    )
    assert len(left) == len(BOARD["bins"]["multipliers"]) - 1
    for edges, pays in left:
        assert len(edges) == len(pays) + 1
        assert edges == sorted(edges)


def test_the_smallest_thing_under_the_pointer_is_found(draft: Run) -> None:
    walls, bins = BOARD["walls"], BOARD["bins"]
    peg = BOARD["pegs"][7]
    places = {
        "peg": [peg["x"] + 0.01, peg["y"]],
        "end": [walls[0]["x1"], walls[0]["y1"] + 0.005],
        "wall": [
            (walls[0]["x1"] + walls[0]["x2"]) / 2,
            (walls[0]["y1"] + walls[0]["y2"]) / 2,
        ],
        "edge": [bins["edges"][4] + 0.01, bins["y"] + 0.2],
        "bin": [(bins["edges"][4] + bins["edges"][5]) / 2, bins["y"] + 0.2],
        "drop": [BOARD["drop"]["x"], BOARD["drop"]["y"]],
        "nothing": [walls[0]["x1"] - 3.0, 1.0],
    }
    found = draft(
        """({ hit }, [board, places]) => Object.fromEntries(Object.entries(places)
          .map(([name, [x, y]]) => [name, hit(board, x, y, 0.03)]))""",
        [BOARD, places],
    )
    assert found == {
        "peg": {"kind": "peg", "index": 7},
        "end": {"kind": "wall", "index": 0, "end": 1},
        "wall": {"kind": "wall", "index": 0},
        "edge": {"kind": "edge", "index": 4},
        "bin": {"kind": "bin", "index": 4},
        "drop": {"kind": "drop", "index": 0},
        "nothing": None,
    }


def test_snapped_places_are_short_decimals(draft: Run) -> None:
    values = [0.3000001, 0.1 + 0.2, -0.149, 1.0249]
    assert draft("({ snap }, list) => list.map((v) => snap(v, 0.05))", values) == [
        0.3,
        0.3,
        -0.15,
        1,
    ]
    assert draft("({ snap }, list) => list.map((v) => snap(v, 0))", values) == values


def test_a_value_is_written_at_its_path_and_nowhere_else(draft: Run) -> None:
    changed = draft(
        """({ written, read }, board) => {
          const before = JSON.stringify(board);
          const next = written(written(board, "pegs[3].x", 9), "ball.radius", 0.5);
          return [next, read(next, "pegs[3].x"), JSON.stringify(board) === before];
        }""",
        BOARD,
    )
    wanted = json.loads(json.dumps(BOARD))
    wanted["pegs"][3]["x"] = 9
    wanted["ball"]["radius"] = 0.5
    assert changed == [wanted, 9, True]


@pytest.mark.parametrize(
    ("field", "detail", "wanted"),
    [
        ("pegs[3].radius", "pegs[3].radius is 0", [["peg", 3]]),
        ("pegs[5]", "pegs[5] at (1, 1) overlaps pegs[2] at (1, 1)", [["peg", 5], ["peg", 2]]),
        ("walls[1]", "walls[1] has no length", [["wall", 1]]),
        ("bins.edges[8]", "a ball can miss the bins", [["edge", 8]]),
        ("drop.y", "the start must be above the bins", [["drop", 0]]),
        ("ball.radius", "the ball cannot pass", []),
        ("pegs[999]", "no such peg is drawn", []),
        (None, "busy", []),
    ],
)
def test_a_refusal_names_what_it_is_about(
    draft: Run, field: str | None, detail: str, wanted: list[Any]
) -> None:
    found = draft(
        "({ refsInProblem }, [board, field, detail]) => refsInProblem(board, field, detail)",
        [BOARD, field, detail],
    )
    assert [[ref["kind"], ref["index"]] for ref in found] == wanted


def test_undo_and_redo_go_back_and_forth_and_a_change_ends_the_future(run: Run) -> None:
    seen = run(
        "editor/history.js",
        """({ EditHistory }) => {
          const history = new EditHistory("a");
          const seen = [history.undo(), history.redo()];
          history.push("b");
          history.push("c");
          history.push("c");
          seen.push(history.undo(), history.board, history.undo(), history.board, history.undo());
          seen.push(history.redo(), history.board);
          history.push("d");
          seen.push(history.canRedo, history.undo(), history.board);
          return seen;
        }""",
    )
    assert seen == [False, False, True, "b", True, "a", False, True, "b", False, True, "b"]
