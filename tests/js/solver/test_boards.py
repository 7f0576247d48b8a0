"""The boards of the editor and of links are valid in the engine, with the same defaults."""

from typing import Any

from plinko.engine import Board
from plinko.engine.board.materials import GRAVITY, RESTITUTION
from plinko.engine.board.presets import preset_names
from plinko.engine.board.worlds import WORLDS
from tests.js.conftest import Run

DRAFT = "editor/draft/draft.js"
BOARD = Board.preset("triangle-8").to_dict()


def test_the_small_board_to_start_with_is_playable(run: Run) -> None:
    assert Board.from_json(run(DRAFT, "({ EMPTY }) => EMPTY")).bins.count == 3


def test_omitted_parts_have_the_server_s_defaults(run: Run) -> None:
    forms: list[dict[str, Any]] = [
        {},
        {"bins": {"multipliers": [1, 2, 3]}},
        {"width": 4, "height": 2, "bins": {"edges": [-2, 2]}},
        {"ball": {"radius": 0.1}, "drop": {"y": 0.5}, "name": "short"},
        BOARD,
    ]
    for form in forms:
        assert run(DRAFT, "({ complete }, form) => complete(form)", form) == (
            Board.from_json(form).to_dict()
        )


def test_a_moved_edge_stays_between_its_neighbours(run: Run) -> None:
    script = "({ moved }, [board, x]) => moved(board, { kind: 'edge', index: 3 }, x, 0).bins.edges"
    for x in (-100.0, 100.0):
        edges = run("editor/draft/element.js", script, [BOARD, x])
        assert edges == sorted(edges)
        assert len(set(edges)) == len(edges)
        Board.from_json({**BOARD, "bins": {**BOARD["bins"], "edges": edges}})


def test_worlds_gravities_and_materials_are_the_engines(run: Run) -> None:
    worlds = run("model/worlds.js", "({ GRAVITY, RESTITUTION }) => ({ GRAVITY, RESTITUTION })")
    assert worlds["GRAVITY"] == dict(GRAVITY)
    assert run("model/presets.js", "({ WORLDS }) => WORLDS") == ["house", *WORLDS]
    ranges = {row.name: [row.low, row.high] for row in RESTITUTION[1:]}
    assert worlds["RESTITUTION"] == ranges


def test_names_of_presets_are_read_and_written_alike(run: Run) -> None:
    script = (
        "({ readBoardName, boardName }, names) => names.map((n) => boardName(readBoardName(n)))"
    )
    assert run("model/presets.js", script, list(preset_names())) == list(preset_names())
    none = [
        "house-16",
        "moon-7",
        "moon-17",
        "moon-16-medium",
        "venus-16",
        "moon16",
        "triangle-16 · Moon",
    ]
    assert run("model/presets.js", "(m, names) => names.map(m.readBoardName)", none) == [None] * 7
