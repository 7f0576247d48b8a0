"""For all tests: a deterministic profile of property tests; kernels compiled before they start.

`make test` tries every claim; those marked `long` are tried many more times by `make test-long`,
which sets LONG=1: see tests/long.py.
"""

import os
import subprocess
import sys

import pytest
from hypothesis import settings

# Property tests try the same examples in every run, and a slow machine fails none of them.
# HYPOTHESIS_PROFILE=search looks for new examples, many more of them.
settings.register_profile("ci", derandomize=True, deadline=None, database=None, max_examples=50)
settings.register_profile("search", deadline=None, max_examples=2000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))

# Servers that tests start keep nothing where a user's server keeps its own; those that are to come
# back are given a directory.
os.environ.setdefault("PLINKO_DATABASE_URL", "sqlite://")


def pytest_configure(config: pytest.Config) -> None:
    """Compile all kernels before there are workers, so that these find them on disk.

    Numba's cache holds up to processes that read it; those that compile one function for different
    types at the same moment may take each other's code. Balls that touch have kernels of their own
    and take the others for the same types, so that two processes may do this at once.
    """
    if hasattr(config, "workerinput"):
        return
    touching = "from tests.conftest import compile_touching; compile_touching()"
    beside = subprocess.Popen([sys.executable, "-c", touching], cwd=config.rootpath)
    compile_alone()
    assert beside.wait() == 0, "the kernels of touching balls do not compile"


def compile_alone() -> None:
    """Run everything once that follows balls one by one."""
    from engine import Board, World, drop, drop_many

    board = Board.preset("triangle-8")
    for solver in ("exact", "stepped"):
        drop(board, 42, solver=solver).states([0.0])
        drop_many(board, [42], solver=solver)
        world = World(board, solver=solver)
        world.add(42)
        world.step()


def compile_touching() -> None:
    """Run everything once that moves balls that touch."""
    from engine import Arena, Board, Place

    arena = Arena(Place.of_board(Board.preset("triangle-8")))
    arena.add(0.0, 0.0)
    arena.step()
    arena.diagnostics()
