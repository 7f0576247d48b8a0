"""For all tests: a deterministic profile of property tests; kernels compiled before they start.

`make test` tries every claim; those marked `long` are tried many more times by `make test-long`,
which sets LONG=1: see tests/long.py.
"""

import os

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
    """Compile all kernels in the first process, so that parallel ones find them on disk.

    Numba's cache holds up to processes that read it; those that compile one function for different
    types at the same moment may take each other's code.
    """
    if hasattr(config, "workerinput"):
        return
    from engine import Arena, Board, Place, World, drop, drop_many

    board = Board.preset("triangle-8")
    for solver in ("exact", "stepped"):
        drop(board, 42, solver=solver).states([0.0])
        drop_many(board, [42], solver=solver)
        world = World(board, solver=solver)
        world.add(42)
        world.step()
    arena = Arena(Place.of_board(board))
    arena.add(0.0, 0.0)
    arena.step()
    arena.diagnostics()
