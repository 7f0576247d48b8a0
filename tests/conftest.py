"""Settings for all tests: deterministic property tests, no files among the user's, long tests.

`make test-long` sets LONG=1: tests marked `long` then try more cases, or run at all, see
tests/long.py.
"""

import functools
import gc
import os
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import is_hypothesis_test, settings

from tests.long import LONG, tries
from tests.rows import in_rows

if TYPE_CHECKING:
    from tests.kit.postgres import PostgreSQL

# A failed assertion in the kit shows its values, as one in a test does.
pytest.register_assert_rewrite("tests.kit")

# Property tests try the same examples in every run that has loaded the same modules: Hypothesis
# also tries the numbers in their sources. They have no deadline, so that they pass on a slow
# machine. HYPOTHESIS_PROFILE=search tries many more, new examples.
settings.register_profile(
    "ci", derandomize=True, deadline=None, database=None, max_examples=tries(25, 500)
)
settings.register_profile("search", deadline=None, max_examples=2000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))

# By default, servers started by tests keep their ledger in memory, not in the user's folder. A test
# that restarts a server gives it a directory.
os.environ.setdefault("PLINKO_DATABASE_URL", "sqlite://")

# No test uses TLS, but each HTTP client would read all certificates of the system. This folder has
# no certificates, which saves that time.
os.environ.pop("SSL_CERT_FILE", None)
os.environ["SSL_CERT_DIR"] = str(Path(__file__).parent)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--checked",
        default="",
        metavar="FOLDERS",
        help="leave out the tests that `make check` has run in these folders",
    )


@pytest.hookimpl(trylast=True)  # after pytest has grouped tests that share fixtures
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    folders = [config.rootpath / folder for folder in config.getoption("checked").split()]
    if folders:
        config.hook.pytest_deselected(items=[each for each in items if _is_checked(each, folders)])
        items[:] = [each for each in items if not _is_checked(each, folders)]
    workers = getattr(config, "workerinput", {}).get("workercount", 1)
    if workers > 1:
        items[:] = in_rows([item.nodeid for item in items], items, workers)


def _is_checked(item: pytest.Item, folders: list[Path]) -> bool:
    """Whether `make check` runs this test if it runs those of `folders`."""
    lies_there = any(item.path.is_relative_to(folder) for folder in folders)
    return lies_there and not any(map(item.get_closest_marker, ("postgresql", "long")))


def pytest_itemcollected(item: pytest.Item) -> None:
    """Mark property tests as `long`, and skip tests that run only with LONG=1."""
    if is_hypothesis_test(getattr(item, "obj", None)):
        item.add_marker("long")
    for marker in () if LONG else item.iter_markers("long"):
        if marker.args:
            item.add_marker(pytest.mark.skip(reason=f"left to `make test-long`: {marker.args[0]}"))


def pytest_collection() -> None:
    """Switch garbage collection off: modules and tests that are collected now stay anyway."""
    gc.disable()


def pytest_collection_finish() -> None:
    """Exclude everything that exists now from later garbage collections."""
    gc.freeze()
    gc.enable()


@pytest.fixture(scope="session")
def postgresql() -> "Iterator[PostgreSQL]":
    """The PostgreSQL server that all tests of a process share; each test has its own databases."""
    from tests.kit import postgres

    if missing := postgres.why_not():
        pytest.skip(missing)
    with postgres.running() as running:
        yield running


@pytest.fixture
def limited_calls(monkeypatch: pytest.MonkeyPatch) -> None:
    """Limit the instructions of each call of `trace_many`, as a server does for all calls."""
    if "NUMBA_DISABLE_JIT" in os.environ:
        pytest.skip("plain Python does not count instructions")
    from plinko.engine.board.cache import BoardCache
    from plinko.engine.drops import trajectory
    from plinko.engine.exact.trace import trace_many
    from plinko.engine.jit import limits, machine_code

    limited = threading.Event()
    limited.set()
    monkeypatch.setattr(limits, "_limited", limited)
    compiler = machine_code._compiler.__wrapped__()
    monkeypatch.setattr(machine_code, "_compiler", lambda: compiler)
    monkeypatch.setattr(machine_code, "modules", functools.cache(machine_code.modules.__wrapped__))
    monkeypatch.setattr(machine_code, "_modules", [])
    again = machine_code.entry(trace_many)  # type: ignore[arg-type]
    monkeypatch.setattr(trace_many, "machine_code", again)
    flights = BoardCache(trajectory._Flights, trajectory._bytes_of, trajectory._KEPT)
    monkeypatch.setattr(trajectory, "_flights_of", flights)
