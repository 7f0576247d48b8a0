"""For all tests: a deterministic profile of property tests, and no files where a user has his.

Tests marked `long` are tried many more times, or only, by `make test-long`, which sets LONG=1: see
tests/long.py.
"""

import functools
import gc
import os
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import pytest
from hypothesis import is_hypothesis_test, settings

from engine.drops import trajectory
from engine.exact.kept import Kept
from engine.exact.trace import trace_many
from engine.jit import limits, machine_code
from engine.jit.decorator import EntryKernel
from tests.kit import postgres
from tests.long import LONG, tries
from tests.rows import in_rows

# Property tests try the same examples in every run, and a slow machine fails none of them.
# HYPOTHESIS_PROFILE=search looks for new examples, many more of them.
settings.register_profile(
    "ci", derandomize=True, deadline=None, database=None, max_examples=tries(25, 500)
)
settings.register_profile("search", deadline=None, max_examples=2000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))

# Servers that tests start keep nothing where a user's server keeps its own; those that are to come
# back are given a directory.
os.environ.setdefault("PLINKO_DATABASE_URL", "sqlite://")

# Nobody here speaks TLS, and each of many HTTP clients would read all of a system's certificates:
# they look for them in a folder that has none.
os.environ.pop("SSL_CERT_FILE", None)
os.environ["SSL_CERT_DIR"] = str(Path(__file__).parent)


@pytest.hookimpl(trylast=True)  # once what shares fixtures stands together
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    workers = getattr(config, "workerinput", {}).get("workercount", 1)
    if workers > 1:
        items[:] = in_rows([item.nodeid for item in items], items, workers)


def pytest_itemcollected(item: pytest.Item) -> None:
    """Property tests try many more examples with LONG=1; some tests run only then."""
    if is_hypothesis_test(getattr(item, "obj", None)):
        item.add_marker("long")
    for marker in () if LONG else item.iter_markers("long"):
        if marker.args:
            item.add_marker(pytest.mark.skip(reason=f"left to `make test-long`: {marker.args[0]}"))


def pytest_collection() -> None:
    """What is imported and found from now on stays, so nobody searches it for garbage."""
    gc.disable()


def pytest_collection_finish() -> None:
    """Nor need later searches go through it again."""
    gc.freeze()
    gc.enable()


@pytest.fixture(scope="session")
def postgresql() -> Iterator[postgres.PostgreSQL]:
    """The one that all tests of a process share, each with databases of its own."""
    if missing := postgres.why_not():
        pytest.skip(missing)
    with postgres.running() as running:
        yield running


@pytest.fixture
def limited_calls(monkeypatch: pytest.MonkeyPatch) -> None:
    """Calls of `trace_many` end after so many instructions, as all do in a server."""
    if "NUMBA_DISABLE_JIT" in os.environ:
        pytest.skip("Python counts nothing")
    limited = threading.Event()
    limited.set()
    monkeypatch.setattr(limits, "_limited", limited)
    compiler = machine_code._compiler.__wrapped__()
    monkeypatch.setattr(machine_code, "_compiler", lambda: compiler)
    monkeypatch.setattr(machine_code, "modules", functools.cache(machine_code.modules.__wrapped__))
    monkeypatch.setattr(machine_code, "_modules", [])
    kernel = cast("EntryKernel[Any, Any]", trace_many)
    monkeypatch.setattr(kernel, "machine_code", machine_code.entry(kernel))
    flights = Kept(trajectory._Flights, trajectory._bytes_of, trajectory._KEPT)
    monkeypatch.setattr(trajectory, "_flights_of", flights)
