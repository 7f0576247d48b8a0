"""One drop, one digest: in a batch and a world, by the command line, over REST, in a live room over
a real WebSocket, and in the room's log.

The page's solver is compared in tests/js and tests/outsider, the npm package in tests/examples.
"""

import contextlib
import io
import json
from collections.abc import Iterator
from typing import Any

import pytest

from plinko.app.cli import main
from plinko.engine import Board, World, drop, drop_many
from plinko.engine.world.events import Landing
from tests.kit.player import playing
from tests.kit.serving import Running, serving

CASES = [("triangle-16", 42), ("triangle-8-low", 2**64 - 1), ("classic", 7)]


@pytest.fixture(scope="module")
def running() -> Iterator[Running]:
    with serving() as here:
        yield here


def by_command_line(board: str, seed: int) -> dict[str, Any]:
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        assert main(["drop", board, "--seed", str(seed), "--json"]) == 0
    record: dict[str, Any] = json.loads(printed.getvalue())
    return record


@pytest.mark.parametrize(("name", "seed"), CASES)
async def test_a_drop_has_one_digest_wherever_it_is_computed(
    running: Running, name: str, seed: int
) -> None:
    one = drop(name, seed)
    record = by_command_line(name, seed)
    assert record == json.loads(json.dumps(one.to_dict()))
    assert drop_many(name, [seed]).digests == (one.digest,)
    world = World(Board.preset(name))
    world.add(seed)
    while world.awake:
        world.step()
    assert [each.digest for each in world.take_events() if isinstance(each, Landing)] == [
        one.digest
    ]
    async with running.async_client() as http:
        assert (await http.get(f"/api/v1/drops/{name}/{seed}")).json() == record
        verdict = (await http.post("/api/v1/verify", json=record)).json()
    assert verdict["ok"] is True
    async with playing(running.socket(name)) as player:
        await player.send(type="drop", seed=str(seed), ref="one")
        accepted = await player.until("accepted", ref="one")
        landed = await player.until("landed", ball=accepted["ball"])
    async with running.async_client() as http:
        log = (await http.get(f"/api/v1/rooms/{name}/log")).json()
    assert log["drops"][accepted["ball"]]["result"]["digest"] == one.digest
    assert (accepted["x"], accepted["explicit_x"]) == (one.x_start, False)
    assert (landed["digest"], landed["bin"], landed["score"]) == (one.digest, one.bin, one.score)
    assert (landed["t"], landed["x_end"]) == (one.duration, one.x_end)
