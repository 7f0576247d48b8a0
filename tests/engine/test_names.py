"""What the package gives by name, and what it costs to import it."""

import subprocess
import sys

import pytest

import engine
from engine import Arena, ArenaSettings, Place, World


def test_every_public_name_is_there_and_listed() -> None:
    assert sorted(engine.__all__, key=str) == sorted(set(engine.__all__))
    for name in engine.__all__:
        assert getattr(engine, name) is not None
        assert name in dir(engine)


def test_names_that_come_when_asked_for_are_the_modules_own() -> None:
    from engine.arena import Arena as OwnArena
    from engine.arena_settings import ArenaSettings as OwnSettings
    from engine.place import Place as OwnPlace
    from engine.world import World as OwnWorld

    assert (Arena, ArenaSettings, Place, World) == (OwnArena, OwnSettings, OwnPlace, OwnWorld)


def test_an_unknown_name_is_said_to_be_one() -> None:
    with pytest.raises(AttributeError, match="module 'engine' has no attribute 'Pinball'"):
        _ = engine.Pinball  # type: ignore[attr-defined]


def test_a_drop_loads_nothing_of_balls_that_touch() -> None:
    code = (
        "import sys\n"
        "from engine import Board, drop\n"
        "drop(Board.preset('triangle-8'), 1)\n"
        "print(*sorted(name for name in sys.modules if 'arena' in name or 'pair_' in name))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=300
    )
    assert done.stdout.split() == []
