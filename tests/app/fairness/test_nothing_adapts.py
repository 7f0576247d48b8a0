"""A drop's path has the same bits for every stake, player and history."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import msgspec
import pytest

from plinko.app.fairness.signing import Signer
from plinko.app.live.sessions.fair_session import FairSession
from plinko.app.protocol.messages import Landed
from plinko.app.rooms.independent import IndependentRoom
from plinko.app.rooms.pending import DropCommand
from plinko.app.rooms.records import DropRow
from plinko.app.rooms.stakes import payout_of
from plinko.engine import Board, drop

NAMES: Final = ("triangle-8-high", "classic")
SEEDS: Final = (3, 2**64 - 1)
PLACE: Final = {"ball", "tick", "payout", "practice"}
"""Fields that depend on a drop's place in the room's history or on its stake."""

STRANGER: Final = DropCommand(0, stake=0, who=None)
PLAYERS: Final = (
    STRANGER,
    replace(STRANGER, stake=1, who="ada"),
    replace(STRANGER, stake=1_000_000_000, who="a whale who lost all day"),
    replace(STRANGER, practice=True),
)


def landings(board: Board, commands: Sequence[DropCommand]) -> list[Landed]:
    """The landings of these drops in one room, each dropped after the last one landed."""
    room = IndependentRoom("r", board, tick_rate=60, max_balls=1)
    ended: list[Landed] = []
    for command in commands:
        room.drop(command)
        while room.awake:
            ended += [event for event in room.step(watched=False) if isinstance(event, Landed)]
    return ended


def fall(landed: Landed) -> dict[str, Any]:
    """A landing's fields, floats bit by bit, without those in PLACE."""
    told = msgspec.to_builtins(landed)
    return {
        name: value.hex() if isinstance(value, float) else value
        for name, value in told.items()
        if name not in PLACE
    }


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("seed", SEEDS)
def test_stake_and_player_change_no_bit_of_a_fall(name: str, seed: int) -> None:
    board = Board.preset(name)
    commands = [replace(each, seed=seed) for each in PLAYERS]
    falls = [fall(landings(board, [command])[0]) for command in commands]
    assert falls == [falls[0]] * len(PLAYERS)
    assert falls[0]["digest"] == drop(board, seed=seed).digest


def test_history_changes_no_bit_of_a_fall_and_no_payout() -> None:
    """The same seed falls the same way after any wins and losses, in any order."""
    board = Board.preset(NAMES[0])
    lives = [replace(each, seed=seed) for seed in (*SEEDS, 11) for each in PLAYERS[:3]]
    forth, back = landings(board, lives), landings(board, lives[::-1])[::-1]
    assert [fall(each) for each in forth] == [fall(each) for each in back]
    assert [each.payout for each in forth] == [each.payout for each in back]
    fresh = {seed: fall(landings(board, [replace(STRANGER, seed=seed)])[0]) for seed in SEEDS}
    for command, landed in zip(lives, forth, strict=True):
        if command.seed in fresh:
            assert fall(landed) == fresh[command.seed]
    # A payout is the stake times the multiplier only.
    commands = [
        replace(each, seed=seed, stake=each.stake or 100) for seed in SEEDS for each in PLAYERS
    ]
    for command, landed in zip(commands, landings(board, commands), strict=True):
        assert landed.bin is not None
        assert landed.payout == payout_of(command.stake, board.bins.multipliers[landed.bin])


def test_a_session_s_seeds_depend_only_on_secrets_and_count() -> None:
    def seeds(commands: Sequence[DropCommand], room: str) -> list[int]:
        session = FairSession(
            room, room, Board.preset("triangle-8").digest, b"s" * 32, {}, "", "", Signer(b"k" * 32),
            used=0.0, client_seed=b"c" * 32,
        )  # fmt: skip
        drawn = []
        for number, command in enumerate(commands):
            turn = session.turn(None, 1000.0 * number)
            drawn.append(turn.seed_of(number))
            fact = DropRow(1, 7 * number, 0, drawn[-1], stake=command.stake, aim=command.aim)
            assert turn.leaf(number, fact).number == number
        return drawn

    poor, rich = [STRANGER] * 4, [replace(PLAYERS[2], aim=0.1), *PLAYERS[1:]]
    assert seeds(poor, "main") == seeds(rich, "triangle-8")
    assert len(set(seeds(poor, "main"))) == 4
