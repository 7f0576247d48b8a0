"""What the committed oracle files hold of a drop, and how a solver's drop is held against it.

A file per board, tests/golden/oracle/<name>.json, made by `python -m tools.oracle.make`.
The numbers are decimal strings of 25 digits, more than a float64 can tell apart.
"""

import json
import random
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import mpmath
import numpy as np
import numpy.typing as npt

from plinko.engine.board.model import Board
from tools.golden.lines import in_lines
from tools.oracle.drop import CUT, Event, OracleDrop, oracle_drop
from tools.oracle.scene import Real

FOLDER: Final = Path(__file__).parents[2] / "tests" / "golden" / "oracle"
DPS: Final = 50
SEED: Final = 20_240_607  # of the starts
FIRST_EVENTS: Final = 8  # written out in full; of the later ones only what was hit
DIGITS: Final = 25
ROUNDING: Final = 2.0**-50  # m: an ulp of a coordinate from 4 to 8 m, the boards' size
ULPS: Final = 4  # roundings that add up at most: every drop kept here stays within two
ENDLESS: Final = 1e300  # in place of an infinite amplification, which JSON cannot say
SHARP: Final = 1e9  # an amplification up to which the turns of two paths must be the same

_CONTEXT = mpmath.MPContext()
_CONTEXT.dps = DPS


@dataclass(frozen=True)
class GoldenDrop:
    """One drop by the oracle. `events`: t x y vx vy omega as decimals, for the first few.

    `turns`: kind and index of every event; `sharp`: of how many of them two runs whose starts
    differ by a rounding cannot disagree about; `growth`: of errors made anywhere on the way, at
    the end, at least 1.
    """

    x: float
    bin: int | None
    duration: str
    x_end: str
    amplification: float
    growth: float
    sharp: int
    turns: str
    events: list[list[str]]

    @property
    def end(self) -> Real:
        """x_end in metres, as an mpf."""
        return _CONTEXT.mpf(self.x_end)


def starts(board: Board, count: int) -> list[float]:
    """The first `count` starts of the sample on `board`, in m; a seeded uniform choice."""
    choice = random.Random(SEED)
    zone = board.drop
    return [choice.uniform(zone.x - zone.jitter, zone.x + zone.jitter) for _ in range(count)]


def turns_of(events: list[Event] | npt.NDArray[np.void]) -> str:
    """Kind and index of each event as text, `0:17 2:17 …`, landings without their bin."""
    pairs = (
        (e.kind, e.index) if isinstance(e, Event) else (int(e["kind"]), int(e["index"]))
        for e in events
    )
    return " ".join(f"{kind}" if kind == 5 else f"{kind}:{index}" for kind, index in pairs)


def golden_of(drop: OracleDrop, x: float) -> GoldenDrop:
    """What is kept of a drop that started at x."""

    def text(number: Real) -> str:
        return str(_CONTEXT.nstr(number, DIGITS))

    sharp = 0
    while sharp < len(drop.events) and drop.growths[sharp] < SHARP:
        sharp += 1
    return GoldenDrop(
        x=x,
        bin=drop.bin,
        duration=text(drop.duration),
        x_end=text(drop.x_end),
        amplification=min(drop.amplification, ENDLESS),
        growth=min(max([1.0, drop.amplification, *drop.growths[-1:]]), ENDLESS),
        sharp=sharp,
        turns=turns_of(drop.events),
        events=[
            [text(number) for number in (e.t, e.x, e.y, e.vx, e.vy, e.omega)]
            for e in drop.events[:FIRST_EVENTS]
        ],
    )


def compute(board: Board, x: float) -> GoldenDrop:
    """The oracle's drop from x as it is kept in the files."""
    return golden_of(oracle_drop(board, x, DPS), x)


def save(name: str, board: Board, drops: list[GoldenDrop]) -> Path:
    """Write the file of a board and return its path."""
    document = {
        "about": "made by python -m tools.oracle.make; do not edit",
        "dps": DPS,
        "cut": CUT,
        "seed": SEED,
        "board": board.to_dict(),
        "board_digest": board.digest,
        "drops": [asdict(drop) for drop in drops],
    }
    FOLDER.mkdir(parents=True, exist_ok=True)
    path = FOLDER / f"{name}.json"
    path.write_text(in_lines(document), encoding="utf-8")
    return path


def load(name: str) -> tuple[dict[str, Any], list[GoldenDrop]]:
    """The head of a board's file and its drops."""
    document = json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
    drops = [GoldenDrop(**drop) for drop in document.pop("drops")]
    return document, drops


def position_errors(drop: GoldenDrop, impacts: npt.NDArray[np.void], count: int) -> list[float]:
    """Distance in m of a solver's first `count` events from the oracle's."""
    errors = []
    for row, impact in zip(drop.events[:count], impacts, strict=False):
        dx, dy = (_CONTEXT.mpf(row[i]) - float(impact[c]) for i, c in ((1, "x"), (2, "y")))
        errors.append(float(mpmath.hypot(dx, dy)))
    return errors


def decidable(drop: GoldenDrop, board: Board) -> bool:
    """Whether the error allowed for rounding, see `bound`, stays short of the nearest bin edge."""
    edge = min(abs(drop.end - edge) for edge in board.bins.edges)
    return bool(bound(drop) < edge)


def bound(drop: GoldenDrop) -> float:
    """Error of x_end in m that rounding may cause: ULPS roundings, grown as the oracle measured."""
    return ULPS * ROUNDING * drop.growth
