"""The bin of a drop as a theorem: precision is doubled until every comparison is decided."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from math import inf, nextafter
from typing import Any, NamedTuple

from flint import arb, fmpq

from engine.board.model import Board
from engine.certified.balls import Proof, UndecidedError, precision
from engine.certified.spread import trace_all
from engine.certified.trace import Path, trace
from engine.drops.drop import make_drop
from engine.drops.start import start_of
from engine.errors import ParameterError
from engine.exact.outcome import EVENT_LIMIT, LANDED, REASONS
from engine.parameters import Exact
from engine.seeding import parse_seed

FIRST_BITS = 160
"""Of precision, at first: what most drops of the presets need."""

MOST_BITS = 12_288
"""Where a drop is given up: FIRST_BITS doubled six times, 3,700 digits."""

MOST_COMPARISONS = 1_000_000
"""In one drop at one precision. A drop of the presets takes a thousand; only a ball that bounces or
rolls almost for ever takes so many."""

MOST_DIGITS = 400
"""Of a start given as text: enough for a map of 1e-300 m."""

_DECIMAL = r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?"
_EXACT = re.compile(f"{_DECIMAL}(/{_DECIMAL})?", re.ASCII)  # Decimal alone reads `1_0` and ` 10`

DIGITS = 25
"""Digits shown of a number that is enclosed more sharply than that."""


@dataclass(frozen=True, slots=True)
class Enclosure:
    """A real number between `low` and `high`, and its first digits as text with the error bound."""

    low: float
    high: float
    text: str

    @classmethod
    def of(cls, x: arb) -> "Enclosure":
        """The ball x, rounded outwards."""
        return cls(_down(x), -_down(-x), x.str(DIGITS))

    def to_dict(self) -> dict[str, Any]:
        """As JSON values."""
        return {"low": self.low, "high": self.high, "text": self.text}


def _down(x: arb) -> float:
    """A float64 that is at most x, and next to it."""
    low = x.lower()
    near = float(low)
    return near if arb(near) <= low else nextafter(near, -inf)


@dataclass(frozen=True, eq=False)
class Certificate:
    """What was proven of a drop. The board's float64 values count as exact.

    bin: None unless the ball is proven to land. unsettled: why it does not land, proven too.
    undecided: which comparison was left open at the last precision; then nothing is proven. ties:
    what happened at the same instant by symmetry, and was decided by the surfaces' numbers.
    agrees: whether the double-precision bin is the same; None if there is none to compare with.
    """

    board: Board
    seed: int | None
    x_start: str
    bin: int | None
    unsettled: str | None
    undecided: str | None
    x_end: Enclosure | None
    duration: Enclosure | None
    impacts: int
    bits: int
    comparisons: int
    ties: tuple[str, ...]
    double_bin: int | None
    agrees: bool | None
    path: Path | None

    @property
    def decided(self) -> bool:
        """Whether the proof gave a bin, or showed that the ball does not land."""
        return self.undecided is None

    def to_dict(self) -> dict[str, Any]:
        """As JSON values."""
        return {
            "certified": self.decided,
            "x": self.x_start,
            "bin": self.bin,
            "unsettled": self.unsettled,
            "undecided": self.undecided,
            "x_end": self.x_end.to_dict() if self.x_end else None,
            "duration": self.duration.to_dict() if self.duration else None,
            "impacts": self.impacts,
            "bits": self.bits,
            "comparisons": self.comparisons,
            "ties": list(self.ties),
            "double_bin": self.double_bin,
            "agrees": self.agrees,
        }

    def event_rows(self) -> list[tuple[float, ...]]:
        """Each event's kind, index, t, x, y and a bound of the error of these three, in s and m."""
        events = self.path.events if self.path is not None else []
        return [(e.kind, e.index, *_rounded(e.state.t, e.state.x, e.state.y)) for e in events]


def _rounded(*balls: arb) -> tuple[float, ...]:
    """The balls' middles as float64, and a bound of how far any number in one is from that."""
    middles = [float(ball) for ball in balls]
    errors = [abs(ball - arb(middle)).upper() for ball, middle in zip(balls, middles, strict=True)]
    return *middles, max(nextafter(float(error), inf) for error in errors)


Start = float | int | str | Fraction
"""An explicit start in m; text and fractions are taken exactly, to any number of digits."""


def _stopped_clock() -> float:
    return 0.0


class Effort(NamedTuple):
    """How far to go: bits of precision, first and at most, comparisons at each of them, and time.

    `seconds` are those of `clock`; without a clock time does not count.
    """

    first_bits: int = FIRST_BITS
    most_bits: int = MOST_BITS
    most_comparisons: int = MOST_COMPARISONS
    seconds: float = inf
    clock: Callable[[], float] = _stopped_clock


FULL = Effort()


class Outcome(NamedTuple):
    """What came of a proof: the path, or what was left undecided at the last precision."""

    path: Path | None
    proof: Proof
    bits: int
    undecided: str | None


def certify(
    board: Board | str,
    seed: int | str | None = None,
    *,
    x: Start | None = None,
    aim: float | None = None,
    effort: Effort = FULL,
) -> Certificate:
    """Prove the bin of the ball that starts where `seed` says, or at an exact `x` in m.

    `aim`, in m, is the middle of the starts that seeds draw; without it, the board's own.

    `board` may be a preset's name. Precision is doubled until every comparison is decided, as far
    as `effort` says. Raises BoardError, SeedError or ParameterError that name the bad value.
    """
    board = Board.named(board)
    number = None if seed is None else parse_seed(seed)
    if x is None:
        return certify_start(board, number, Fraction(start_of(board, number, None, aim)), effort)
    exact = exact_start(x)
    start_of(board, None, float(exact), aim)
    return certify_start(board, number, exact, effort)


def exact_start(x: Start) -> Fraction:
    """The number that is meant, in m; ParameterError unless it is finite and of a sane size."""
    try:
        return _exact(x) if isinstance(x, str) else Fraction(x)
    except (ArithmeticError, ValueError):
        shown = repr(x) if len(repr(x)) <= 40 else repr(x)[:37] + "..."
        raise ParameterError(
            f"x {shown} is no finite number of {MOST_DIGITS} digits at most, such as 0.125 or 1/3",
            field="x",
        ) from None


def _exact(text: str) -> Fraction:
    """A decimal, or a fraction of two; ValueError for what would fill the memory with digits."""
    if len(text) > MOST_DIGITS or _EXACT.fullmatch(text) is None:
        raise ValueError(text)
    parts = [Decimal(part) for part in text.split("/", 1)]
    if not all(part.is_finite() and abs(part.adjusted()) <= MOST_DIGITS for part in parts):
        raise ValueError(text)
    return Fraction(parts[0]) / (Fraction(parts[1]) if len(parts) > 1 else 1)


def certify_start(
    board: Board, seed: int | None, x: Fraction, effort: Effort = FULL
) -> Certificate:
    """`certify` of a seed and a start that have been read."""
    path, proof, bits, undecided = prove(board, x, effort=effort)
    nearest = float(x)
    double_bin = make_drop(board, None, nearest, Exact()).bin
    landed = path is not None and path.outcome == LANDED
    last = path.events[-1].state if path is not None and landed else None
    return Certificate(
        board=board,
        seed=seed,
        x_start=str(nearest) if Fraction(nearest) == x else str(x),
        bin=path.bin if path is not None and landed else None,
        unsettled=None if path is None or landed else REASONS[path.outcome],
        undecided=undecided,
        x_end=Enclosure.of(last.x) if last else None,
        duration=Enclosure.of(last.t) if last else None,
        impacts=path.impacts if path is not None else 0,
        bits=bits,
        comparisons=proof.comparisons,
        ties=tuple(proof.ties),
        double_bin=double_bin,
        agrees=None if path is None else double_bin == (path.bin if landed else None),
        path=path,
    )


def prove(
    board: Board, x: Fraction, radius: Fraction = Fraction(0), effort: Effort = FULL
) -> Outcome:
    """Follow the ball from all starts within `radius` of x, in m, at ever more bits."""
    bits, clock = effort.first_bits, effort.clock
    until = clock() + effort.seconds
    while True:
        proof = Proof(effort.most_comparisons, lambda: clock() < until)
        try:
            with precision(bits):
                start = _start(x, radius)
                path = (
                    trace_all(board, start, bits, proof)
                    if radius
                    else trace(board, start, bits, proof)
                )
            if path.outcome != EVENT_LIMIT:
                return Outcome(path, proof, bits, None)
            return Outcome(None, proof, bits, REASONS[EVENT_LIMIT])
        except UndecidedError as error:
            if clock() >= until:
                why = f"{error.what}: not within {effort.seconds:g} s, at {bits} bits by then"
                return Outcome(None, proof, bits, why)
            if 2 * bits > effort.most_bits:
                return Outcome(None, proof, bits, f"{error.what}: not with {bits} bits")
        bits *= 2


def _start(x: Fraction, radius: Fraction) -> arb:
    middle = arb(fmpq(x.numerator, x.denominator))
    return middle + arb(0, arb(fmpq(radius.numerator, radius.denominator)))
