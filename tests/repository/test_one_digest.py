"""One drop, one digest, wherever it is computed: a table of places and drops.

The page's solver is compared in tests/js and tests/outsider, the npm package in tests/examples.
"""

import contextlib
import io
import json
from collections.abc import Awaitable, Callable, Iterator
from typing import Any

import pytest

from plinko.app.cli import main
from plinko.engine import Board, World, drop, drop_many
from plinko.engine.world.events import Landing
from tests.kit.player import playing
from tests.kit.serving import Running, serving

How = dict[str, Any]  # where a drop starts, and the solver's parameters

STEPPED: How = {"solver": "stepped", "dt": 0.01, "substeps": 2}
DROPS: list[tuple[str, int, How]] = [
    ("triangle-16", 42, {}),
    ("triangle-8-low", 2**64 - 1, {}),
    ("classic", 2**53 + 1, {"x": -0.5}),
    ("triangle-8", 0, {"x": -0.0}),
    ("triangle-9", 7, {"aim": 0.01}),
    ("triangle-8", 1, {"x": 0.1, **STEPPED}),
]


@pytest.fixture(scope="module")
def running() -> Iterator[Running]:
    with serving() as here:
        yield here


async def a_batch(_: Running, board: str, seed: int, how: How) -> str:
    xs = [how["x"]] if "x" in how else None
    options = {name: value for name, value in how.items() if name != "x"}
    return drop_many(board, [seed], xs=xs, **options).digests[0]


async def a_world(_: Running, board: str, seed: int, how: How) -> str:
    world = World(Board.preset(board))
    world.add(seed, **how)
    while world.awake:
        world.step()
    (landed,) = (each for each in world.take_events() if isinstance(each, Landing))
    return landed.digest


async def the_command_line(_: Running, board: str, seed: int, how: How) -> Any:
    options = [word for name, value in how.items() for word in (f"--{name}", str(value))]
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        assert main(["drop", board, "--seed", str(seed), *options, "--json"]) == 0
    return json.loads(printed.getvalue())


async def an_address(running: Running, board: str, seed: int, how: How) -> Any:
    async with running.async_client() as http:
        return (await http.get(f"/api/v1/drops/{board}/{seed}", params=how)).json()


async def a_request(running: Running, board: str, seed: int, how: How) -> Any:
    records = []
    async with running.async_client() as http:
        for named in (board, Board.preset(board).digest, Board.preset(board).to_dict()):
            body = {"board": named, "seed": str(seed), **how}
            records.append((await http.post("/api/v1/drops", json=body)).json())
        assert (await http.post("/api/v1/verify", json=records[0])).json()["ok"]
    assert records == records[:1] * 3
    return records[0]


async def a_room_and_its_log(running: Running, board: str, seed: int, how: How) -> str:
    async with running.async_client() as http:
        room = (await http.post("/api/v1/rooms", json={"board": board})).json()["id"]
        async with playing(running.socket(room)) as player:
            await player.send(type="drop", seed=str(seed), **how)
            accepted = await player.until("accepted")
            landed = await player.until("landed")
        (told,) = (await http.get(f"/api/v1/rooms/{room}/log")).json()["drops"]
    one = drop(board, seed, **how)
    assert (accepted["x"], accepted["explicit_x"]) == (one.x_start, "x" in how)
    assert accepted.get("aim") == how.get("aim")
    assert (landed["bin"], landed["score"]) == (one.bin, one.score)
    assert (landed["t"], landed["x_end"]) == (one.duration, one.x_end)
    assert told["result"]["digest"] == landed["digest"]
    return str(landed["digest"])


Place = Callable[[Running, str, int, How], Awaitable[Any]]

ANY: list[Place] = [a_batch, the_command_line, an_address, a_request]
EXACT: list[Place] = [*ANY, a_world, a_room_and_its_log]


@pytest.mark.parametrize(
    ("board", "seed", "how", "place"),
    [(*case, place) for case in DROPS for place in (ANY if "solver" in case[2] else EXACT)],
    ids=lambda value: getattr(value, "__name__", str(value)),
)
async def test_a_drop_has_one_digest_wherever_it_is_computed(
    running: Running, board: str, seed: int, how: How, place: Place
) -> None:
    one = drop(board, seed, **how)
    found = await place(running, board, seed, how)
    assert found == (one.digest if isinstance(found, str) else json.loads(one.to_json()))
