"""One drop, one digest: by the engine, in a batch, in a world, by the command line, over REST, in a
live room over a real WebSocket, and after a record's way through JSON and back."""

import contextlib
import io
import json
from collections.abc import Iterator
from typing import Any

import pytest

from app.cli import main
from engine import Board, World, drop, drop_many, verify
from engine.world.events import Landing
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


def in_a_world(board: Board, seed: int) -> str:
    world = World(board)
    world.add(1)  # another ball
    world.step()
    world.add(seed)
    while world.awake:
        world.step()
    found = [e for e in world.take_events() if isinstance(e, Landing) and e.seed == seed]
    return found[0].digest


async def in_a_room(running: Running, board: str, seed: int) -> str:
    async with playing(running.socket(board)) as player:
        await player.send(type="drop", seed=str(seed), ref="one")
        accepted = await player.until("accepted", ref="one")
        landed = await player.until("landed", ball=accepted["ball"])
        digest: str = landed["digest"]
        return digest


@pytest.mark.parametrize(("name", "seed"), CASES)
async def test_a_drop_has_one_digest_wherever_it_is_computed(
    running: Running, name: str, seed: int
) -> None:
    board = Board.preset(name)
    one = drop(board, seed)
    assert drop_many(board, [0, seed, 1]).digests()[1] == one.digest
    assert in_a_world(board, seed) == one.digest
    record = by_command_line(name, seed)
    assert record["digest"] == one.digest
    assert record == json.loads(json.dumps(one.to_dict()))
    assert verify(record).ok
    async with running.async_client() as http:
        over_rest = (await http.get(f"/api/v1/drops/{name}/{seed}")).json()
        verdict = (await http.post("/api/v1/verify", json=over_rest)).json()
    assert over_rest == record
    assert verdict["ok"] is True
    assert await in_a_room(running, name, seed) == one.digest


@pytest.mark.parametrize(("name", "seed"), CASES[:1])
def test_the_stepped_solver_has_one_digest_too(name: str, seed: int) -> None:
    board = Board.preset(name)
    one = drop(board, seed, solver="stepped")
    assert drop_many(board, [seed], solver="stepped").digests() == [one.digest]
    world = World(board, solver="stepped")
    world.add(seed)
    while world.awake:
        world.step()
    assert [e.digest for e in world.take_events() if isinstance(e, Landing)] == [one.digest]
    assert verify(json.loads(json.dumps(one.to_dict()))).ok
    assert one.digest != drop(board, seed).digest
