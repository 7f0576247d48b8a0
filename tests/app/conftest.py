"""A server shared by all tests of a process, and a board with short falls."""

import contextlib
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

import pytest

# The fixtures import the server: pytest reads this file before it has started any worker.
if TYPE_CHECKING:
    import httpx

    from tests.kit.serving import Running

# Balls land within two thirds of a second: live tests wait for real falls.
TINY = {
    "name": "tiny",
    "width": 3.0,
    "height": 2.0,
    "pegs": [{"x": 0.0, "y": 1.0, "radius": 0.05}],
    "walls": [
        {"x1": -1.5, "y1": -1.0, "x2": -1.5, "y2": 2.0},
        {"x1": 1.5, "y1": -1.0, "x2": 1.5, "y2": 2.0},
    ],
    "bins": {"y": 2.0, "edges": [-1.5, 0.0, 1.5], "multipliers": [1.0, 2.0]},
    "drop": {"x": 0.0, "y": 0.0, "jitter": 0.5},
}

# Balls land within two ticks, for tests that need results and no flight.
QUICK: Final[dict[str, Any]] = {**TINY, "name": "quick", "gravity": 4000.0}


@pytest.fixture(scope="session", autouse=True)
def what_starts_read() -> None:
    from tests.kit.serving import share_what_starts_read

    share_what_starts_read()


@pytest.fixture(scope="session", autouse=True)
def stakes_on_tiny() -> Iterator[None]:
    from tests.kit.serving import constants
    from tests.kit.stakes import taken

    with constants(**{"plinko.app.rooms.independent.takes_stakes": taken}):
        yield


# One address may open a tenth of the rooms.
PLENTY: Final[dict[str, Any]] = {"drop_rate": 1000.0, "max_rooms": 100_000}


@pytest.fixture(scope="session")
def server() -> "Iterator[Running]":
    from tests.kit.serving import constants, serving

    with contextlib.ExitStack() as stack:
        with constants(**{"plinko.app.web.computing.COMPUTE_BURST": 1e6}):
            running = stack.enter_context(serving(**PLENTY))
        yield running


@pytest.fixture(scope="session")
def http(server: "Running") -> "Iterator[httpx.Client]":
    with server.client() as client:
        yield client
