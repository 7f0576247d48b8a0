"""The payout tables of the presets, as `plinko payouts` solved them for a return of 99 %.

`payouts.json`, next to this file, has a line for each preset: its name, the digest of its board,
and the multipliers from the edge bin to the centre. An odd number of rows makes an even number of
bins, so the two middle bins share the last value. `plinko payouts NAME --tables FILE` writes it.

A board with such a digest is known to be playable and skips that check, which takes tens of
milliseconds. A test checks every preset, and that the file has exactly their digests.
"""

import json
from collections.abc import Mapping
from importlib.resources import files
from typing import Final, Literal, NamedTuple

Risk = Literal["low", "medium", "high"]

RISKS: Final[tuple[Risk, ...]] = ("medium", "low", "high")

ROWS: Final = tuple(range(8, 17))
"""Row counts that have a table."""


class Table(NamedTuple):
    """A solved payout table: its board's digest, and multipliers from the edge to the centre."""

    digest: str
    half: tuple[float, ...]


def _read() -> dict[str, Table]:
    text = files("plinko.engine.board").joinpath("payouts.json").read_text(encoding="utf-8")
    return {name: Table(digest, tuple(half)) for name, (digest, half) in json.loads(text).items()}


TABLES: Final[Mapping[str, Table]] = _read()
"""By the name of their preset."""

NAMES: Final[Mapping[str, str]] = {table.digest: name for name, table in TABLES.items()}
"""The name of each preset, by the digest of its board."""


def both_halves(half: tuple[float, ...], rows: int) -> tuple[float, ...]:
    """Mirror a table from the edge to the centre, for `rows` + 1 bins."""
    centre_stands_once = rows % 2 == 0
    return half + half[-2::-1] if centre_stands_once else half + half[::-1]
