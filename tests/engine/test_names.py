"""What the package gives by name, and what it costs to import it."""

import pytest

import engine
from tests.engine.test_determinism import run_python


def test_every_public_name_is_there_and_listed_before_it_is_asked_for() -> None:
    code = (
        "import engine\n"
        "listed = dir(engine)\n"
        "print(*(name for name in engine.__all__ if name not in listed))\n"
        "for name in engine.__all__: getattr(engine, name)\n"
    )
    assert run_python(code).split() == []
    assert len(set(engine.__all__)) == len(engine.__all__)


def test_an_unknown_name_is_said_to_be_one() -> None:
    with pytest.raises(AttributeError, match="module 'engine' has no attribute 'Pinball'"):
        _ = engine.Pinball  # type: ignore[attr-defined]


@pytest.mark.parametrize("use", ["drop(board, 1)", "World(board, solver='stepped').add(1)"])
def test_a_drop_and_a_world_load_nothing_of_balls_that_touch(use: str) -> None:
    code = (
        "import sys\n"
        "from engine import Board, World, drop\n"
        "board = Board.preset('triangle-8')\n"
        f"{use}\n"
        "print(*sorted(name for name in sys.modules if 'multibody' in name))\n"
    )
    assert run_python(code).split() == []
