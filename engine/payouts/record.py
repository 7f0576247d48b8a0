"""Where the presets' drops landed, on record: some chose the payout tables, later ones judge them.

A table fitted to a sample has the wanted return on that sample, even if its true return differs. So
the stated return of a preset comes only from drops of later seeds.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, reduce
from importlib.resources import files
from itertools import chain
from typing import Final

import msgspec

from plinko.engine import json_text
from plinko.engine.batches.workers import Workers
from plinko.engine.board import presets
from plinko.engine.board.model import Board
from plinko.engine.errors import EngineError, RecordError, shorten
from plinko.engine.payouts import landings
from plinko.engine.payouts.landings import Count, Landings
from plinko.engine.payouts.odds import Odds, odds_of
from plinko.engine.payouts.solve import FEWEST, PRECISE, PRECISE_AIM, PRECISE_WORLD, Block, needed

NAME: Final = "record.json"
"""A file in this module's folder."""

LEAST: Final = 1_000_000
"""Fewest drops that judge a table from a board's own start."""

LEAST_AIMED: Final = 750_000
"""The same for any other aim."""

LEAST_WORLD: Final = 400_000
"""The same for a world's preset."""


class Counted(msgspec.Struct, frozen=True):
    """The landings on one board in consecutive blocks of seeds.

    chosen: for each payout variant of the board, the number of blocks, from the first, for which
    its multipliers were solved. The later blocks judge it.
    """

    blocks: tuple[Block, ...]
    chosen: Mapping[str, Count]

    def all(self) -> Block:
        return _sum(self.blocks)

    def fresh(self, name: str) -> Block:
        """The landings that judge the table of the preset `name`."""
        return _sum(self.blocks[self.chosen[name] :])

    def odds(self, name: str) -> tuple[Odds, ...]:
        """The odds of the preset `name` from the drops that judge it, its own start first."""
        pays = pays_of(name)
        return tuple(odds_of(each, pays) for each in self.fresh(name))

    def grown(self, aim: int, found: Landings) -> "Counted":
        """A copy in which `found` replaces the newest block's landings from the given aim."""
        newest = (*self.blocks[-1][:aim], found, *self.blocks[-1][aim + 1 :])
        return msgspec.structs.replace(self, blocks=(*self.blocks[:-1], newest))

    def solved_again(self, name: str) -> "Counted":
        """A copy after the table of `name` was solved for all landings until now.

        A new block begins, whose landings judge the table.
        """
        begun = tuple(landings.none_after(each) for each in self.blocks[-1])
        filled = self.blocks[:-1] if begun == self.blocks[-1] else self.blocks
        return Counted((*filled, begun), {**self.chosen, name: len(filled)})


Record = dict[str, Counted]
"""The landings by preset; its payout variants share an entry under the plain name."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """The drops that are still needed to know the return of `table` from one aim precisely enough.

    board: its name in the record. aim: index in `aims_of`. drops: how many more.
    """

    board: str
    table: str
    aim: int
    drops: int


def wanted(record: Record) -> list[Wanted]:
    """All tables and aims that need more drops, those with the fewest first."""
    found = [
        Wanted(name, table, aim, more)
        for name, counted in record.items()
        for table in counted.chosen
        for aim, more in enumerate(_needs(counted, table))
        if more > 0
    ]
    return sorted(found, key=lambda each: each.drops)


def still_to_drop(needs: Sequence[Wanted]) -> int:
    """Drops that satisfy all of `needs`; a drop counts for all tables of its board and aim."""
    most: dict[tuple[str, int], int] = {}
    for each in needs:
        place = each.board, each.aim
        most[place] = max(most.get(place, 0), each.drops)
    return sum(most.values())


def counted_on(record: Record, want: Wanted, drops: int, workers: Workers | None = None) -> Record:
    """Return the record with `drops` more drops on the board and from the aim of `want`."""
    counted = record[want.board]
    grown = landings.more(Board.preset(want.board), counted.blocks[-1][want.aim], drops, workers)
    return {**record, want.board: counted.grown(want.aim, grown)}


def pays_of(name: str) -> tuple[float, ...]:
    """The multipliers of a preset. A triangle is not laid out, because there are dozens."""
    found = name in presets.VARIANTS
    return presets.payouts_of(name) if found else Board.preset(name).bins.multipliers


def _needs(counted: Counted, table: str) -> list[int]:
    """How many more drops each aim needs, estimated from the volatility measured until now."""
    variant, pays = presets.VARIANTS.get(table), pays_of(table)
    house = variant is None or variant.world == presets.HOUSE
    pairs = zip(counted.all(), counted.fresh(table), strict=True)
    needs = []
    for k, (every, fresh) in enumerate(pairs):
        known = fresh if fresh.drops >= FEWEST else every
        if k:
            precise, least = PRECISE_AIM, LEAST_AIMED
        elif house:
            precise, least = PRECISE, LEAST
        else:
            precise, least = PRECISE_WORLD, LEAST_WORLD
        needs.append(max(needed(odds_of(known, pays), precise), least) - fresh.drops)
    return needs


def _sum(blocks: Sequence[Block]) -> Block:
    return tuple(reduce(landings.joined, row) for row in zip(*blocks, strict=True))


def to_text(record: Record) -> str:
    """The text of the file: JSON with a line for each aim of each block."""
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
    """Read the text of the file; RecordError or JsonSyntaxError if it is not a record."""
    try:
        record = msgspec.convert(json_text.parse(text), Record)
    except msgspec.ValidationError as error:
        raise RecordError(f"this is not a record of drops: {error}") from None
    for name, counted in record.items():
        _check(name, counted)
    return record


def _check(name: str, counted: Counted) -> None:
    """Raise RecordError if an entry contradicts its board or itself."""
    if name not in presets.preset_names() or presets.plain_name(name) != name:
        raise RecordError(f"{shorten(name)} is not a preset whose returns are recorded", field=name)
    bins = len(pays_of(name))
    shapes = {tuple(len(each.histogram) for each in block) for block in counted.blocks}
    if len(shapes) != 1 or {*chain(*shapes)} != {bins}:
        raise RecordError(
            f"{name}: each block must have the same aims with {bins} bins each", field=name
        )
    for table, first in counted.chosen.items():
        if table not in presets.preset_names() or presets.plain_name(table) != name:
            raise RecordError(
                f"chosen has {shorten(table)}, which is not a payout table of {name}", field=name
            )
        if first >= len(counted.blocks):
            raise RecordError(f"{name}: chosen is {first}, but the blocks are fewer", field=name)
    try:
        counted.all()  # the seeds of each block must follow those of the one before
    except EngineError as error:
        raise RecordError(f"{name}: {error}", field=name) from None


@cache
def shipped() -> Record:
    """The record that this release ships."""
    return from_text(files("plinko.engine.payouts").joinpath(NAME).read_text(encoding="utf-8"))


def odds_of_record(board: Board | str) -> tuple[Odds, ...]:
    """The odds of a preset from the drops that judge its table, its own start first.

    board: a Board, or a preset's name. Empty for a board that is not a preset.
    """
    board = Board.named(board)
    counted = shipped().get(presets.plain_name(board.name))
    if counted is None or board.preset_name is None:
        return ()
    return counted.odds(board.name)
