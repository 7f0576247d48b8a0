"""Where the presets' drops landed, on record: which of them chose the tables, and which judge them.

A table that was solved for some drops returns what it should by these drops, whatever it truly
returns. So what a preset returns is stated by drops of later seeds alone.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, reduce
from importlib.resources import files
from typing import Any, Final

from engine.batches.workers import Workers
from engine.board import presets
from engine.board.model import Board
from engine.payouts import landings
from engine.payouts.landings import Landings
from engine.payouts.odds import Odds, odds_of
from engine.payouts.solve import FEWEST, Block, needed

NAME: Final = "record.json"
"""The file beside this module."""

LEAST: Final = 1_000_000
"""Drops that judge a table from a board's own start at least."""

LEAST_AIMED: Final = 750_000
"""And from any other aim."""


@dataclass(frozen=True, slots=True)
class Counted:
    """Of one board: blocks of seeds that follow one another, and which of them chose its tables.

    chosen: a preset that is this board to the ball -> how many blocks, from the first, its
    multipliers were solved for. The blocks after these judge it.
    """

    blocks: tuple[Block, ...]
    chosen: Mapping[str, int]

    def all(self) -> Block:
        """Everything that was counted."""
        return _sum(self.blocks)

    def fresh(self, name: str) -> Block:
        """What judges the table of the preset `name`."""
        return _sum(self.blocks[self.chosen[name] :])

    def grown(self, aim: int, found: Landings) -> "Counted":
        """With `found` for the newest block's landings of the aim of that number."""
        newest = (*self.blocks[-1][:aim], found, *self.blocks[-1][aim + 1 :])
        return replace(self, blocks=(*self.blocks[:-1], newest))

    def solved_anew(self, name: str) -> "Counted":
        """As it is once the table of `name` was chosen by all that was counted so far."""
        begun = tuple(landings.none_after(each) for each in self.blocks[-1])
        filled = self.blocks[:-1] if begun == self.blocks[-1] else self.blocks
        return Counted((*filled, begun), {**self.chosen, name: len(filled)})


Record = dict[str, Counted]
"""Name of a preset, without its payout variant -> what was counted."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """Drops that are needed until the return of `table` from one aim is known as it should be.

    board: the record's name for it. aim: its number. drops: how many more.
    """

    board: str
    table: str
    aim: int
    drops: int


def wanted(record: Record) -> list[Wanted]:
    """What is needed for every table and aim that is not known well enough, the cheapest first."""
    found = [
        Wanted(name, table, aim, more)
        for name, counted in record.items()
        for table in counted.chosen
        for aim, more in enumerate(_needs(counted, table))
        if more > 0
    ]
    return sorted(found, key=lambda each: each.drops)


def still_to_drop(needs: Sequence[Wanted]) -> int:
    """Drops that fulfil all of `needs`: those of one board and aim count for all its tables."""
    most: dict[tuple[str, int], int] = {}
    for each in needs:
        place = each.board, each.aim
        most[place] = max(most.get(place, 0), each.drops)
    return sum(most.values())


def counted_on(record: Record, want: Wanted, drops: int, workers: Workers | None = None) -> Record:
    """The record with `drops` more of the board and from the aim that are wanted."""
    counted = record[want.board]
    grown = landings.more(Board.preset(want.board), counted.blocks[-1][want.aim], drops, workers)
    return {**record, want.board: counted.grown(want.aim, grown)}


def _needs(counted: Counted, table: str) -> list[int]:
    """More drops that each aim needs, by what the volatility is so far."""
    pays = Board.preset(table).bins.multipliers
    pairs = zip(counted.all(), counted.fresh(table), strict=True)
    needs = []
    for k, (every, fresh) in enumerate(pairs):
        known = fresh if fresh.drops >= FEWEST else every
        least = LEAST if k == 0 else LEAST_AIMED
        needs.append(max(needed(odds_of(known, pays), own=k == 0), least) - fresh.drops)
    return needs


def _sum(blocks: Sequence[Block]) -> Block:
    return tuple(reduce(landings.joined, row) for row in zip(*blocks, strict=True))


def to_text(record: Record) -> str:
    """As the file has it: JSON, a line for each aim of each block."""
    boards = []
    for name, counted in record.items():
        blocks = [
            ",\n".join(f"   {json.dumps(each.to_dict())}" for each in block)
            for block in counted.blocks
        ]
        listed = ",\n".join(f"  [\n{block}\n  ]" for block in blocks)
        chosen = json.dumps(dict(counted.chosen))
        boards.append(f' "{name}": {{\n  "chosen": {chosen},\n  "blocks": [\n{listed}\n  ]\n }}')
    return "{\n" + ",\n".join(boards) + "\n}\n"


def from_text(text: str) -> Record:
    """A record from its JSON."""
    forms: dict[str, dict[str, Any]] = json.loads(text)
    return {
        name: Counted(
            tuple(tuple(map(landings.landings_of, block)) for block in form["blocks"]),
            form["chosen"],
        )
        for name, form in forms.items()
    }


@cache
def shipped() -> Record:
    """The record that came with this release."""
    return from_text(files("engine.payouts").joinpath(NAME).read_text(encoding="utf-8"))


def landings_of_record(name: str) -> Block:
    """All of the preset `name` that were counted, the board's own start first; empty if none were.

    Payout variants are one board to the ball.
    """
    counted = shipped().get(presets.plain_name(name))
    return counted.all() if counted else ()


def odds_of_record(board: Board) -> tuple[Odds, ...]:
    """Of a preset as it ships, by the drops that judge its table, its own start first."""
    counted = shipped().get(presets.plain_name(board.name))
    if counted is None or Board.preset(board.name).digest != board.digest:
        return ()
    return tuple(odds_of(each, board.bins.multipliers) for each in counted.fresh(board.name))
