"""Proves the bin of a drop: doubles the precision until every comparison is decided."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from math import inf, nextafter
from typing import Any, NamedTuple

from flint import arb, fmpq

from plinko.engine.board.model import Board
from plinko.engine.certified.balls import Proof, UndecidedError, precision
from plinko.engine.certified.spread import trace_all
from plinko.engine.certified.trace import MAX_EVENTS, Path, trace
from plinko.engine.drops.drop import make_drop
from plinko.engine.drops.start import start_of
from plinko.engine.errors import ParameterError, shorten
from plinko.engine.exact.outcome import EVENT_LIMIT, LANDED, REASONS
from plinko.engine.parameters import Exact
from plinko.engine.seeding import parse_seed

FIRST_BITS = 160
"""Precision of the first attempt: enough for most drops of the presets."""

MOST_BITS = 12_288
"""Precision of the last attempt: FIRST_BITS doubled six times, 3,700 digits."""

MOST_COMPARISONS = 1_000_000
"""In one drop at one precision. A drop of the presets takes a thousand; only a ball that bounces or
rolls almost for ever reaches the limit."""

MOST_DIGITS = 400
"""Longest start that is accepted as text: enough for a map 1e-300 m wide."""

_DECIMAL = r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?"
_EXACT = re.compile(f"{_DECIMAL}(/{_DECIMAL})?", re.ASCII)  # Decimal alone reads `1_0` and ` 10`

DIGITS = 25
"""Most digits that are shown of a number, however sharp its enclosure."""


@dataclass(frozen=True, slots=True)
class Enclosure:
    """A real number between `low` and `high`, and its first digits as text with the error bound."""

    low: float
    high: float
    text: str

    @classmethod
    def of(cls, x: arb) -> "Enclosure":
        """The ball x, with both bounds rounded outwards."""
        return cls(_down(x), -_down(-x), x.str(DIGITS))

    def to_dict(self) -> dict[str, Any]:
        return {"low": self.low, "high": self.high, "text": self.text}


def _down(x: arb) -> float:
    """The largest float64 that is at most the lower bound of x, or the one before."""
    low = x.lower()
    near = float(low)
    return near if arb(near) <= low else nextafter(near, -inf)


@dataclass(frozen=True, eq=False)
class Certificate:
    """What was proven about a drop. The board's float64 values are taken as exact numbers.

    bin: None unless the ball is proven to land. unsettled: the proven reason why it does not land.
    undecided: the comparison that was open at the last precision; if set, nothing is proven. ties:
    impacts that symmetry makes simultaneous, which the surfaces' numbers put in order. agrees:
    whether the double-precision bin is the proven one; None if nothing is proven.
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
        """Whether a bin is proven, or that the ball does not land."""
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
        """Rows kind, index, t, x, y and a bound of the error of the last three, in s and m."""
        events = self.path.events if self.path is not None else []
        return [(e.kind, e.index, *_rounded(e.state.t, e.state.x, e.state.y)) for e in events]


def _rounded(*balls: arb) -> tuple[float, ...]:
    """The balls' middles as float64, then a bound of the errors of all of them."""
    middles = [float(ball) for ball in balls]
    errors = [abs(ball - arb(middle)).upper() for ball, middle in zip(balls, middles, strict=True)]
    return *middles, max(nextafter(float(error), inf) for error in errors)


Start = float | int | str | Fraction
"""An explicit start in m; text and fractions are exact, with as many digits as they have."""


def _stopped_clock() -> float:
    return 0.0


class Effort(NamedTuple):
    """Limits of a proof: first and last precision, comparisons at each precision, and time.

    `clock` measures the `seconds`; the default clock stands still, so that time has no limit.
    """

    first_bits: int = FIRST_BITS
    most_bits: int = MOST_BITS
    most_comparisons: int = MOST_COMPARISONS
    seconds: float = inf
    clock: Callable[[], float] = _stopped_clock


FULL = Effort()


class Outcome(NamedTuple):
    """The result of a proof: the path, or the comparison that the last precision left open."""

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
    seconds: float | None = None,
    clock: Callable[[], float] | None = None,
    effort: Effort = FULL,
) -> Certificate:
    """Prove the bin of the ball that starts where `seed` says, or at an exact `x` in m.

    `aim`, in m, is the middle of the starts that seeds draw; by default the board's. `board` may be
    a preset's name. After `seconds` of `clock`, such as `time.process_time`, the drop is undecided;
    without them only the precision is limited, and a proof may take minutes. Raises BoardError,
    SeedError or ParameterError that names the bad value.
    """
    effort = _timed(effort, seconds, clock)
    board = Board.named(board)
    number = None if seed is None else parse_seed(seed)
    if x is None:
        return certify_start(board, number, Fraction(start_of(board, number, None, aim)), effort)
    exact = exact_start(x)
    start_of(board, None, float(exact), aim)
    return certify_start(board, number, exact, effort)


def _timed(effort: Effort, seconds: float | None, clock: Callable[[], float] | None) -> Effort:
    if seconds is None and clock is None:
        return effort
    if seconds is None or not seconds > 0.0:
        raise ParameterError(f"seconds {seconds!r} is not a positive number", field="seconds")
    if clock is None:
        raise ParameterError(
            f"seconds {seconds!r} need a clock that measures them: add clock=time.process_time",
            field="clock",
        )
    return effort._replace(seconds=seconds, clock=clock)


def exact_start(x: Start) -> Fraction:
    """x as an exact number of m. Raises ParameterError if it is not finite or too long."""
    try:
        return _exact(x) if isinstance(x, str) else Fraction(x)
    except (ArithmeticError, ValueError):
        raise ParameterError(
            f"x {shorten(x, 40)} is not a finite number with at most {MOST_DIGITS} digits;"
            " write it like 0.125 or 1/3",
            field="x",
        ) from None


def _exact(text: str) -> Fraction:
    """A decimal, or a fraction of two.

    Raises ValueError for an exponent beyond MOST_DIGITS too: the integer that `1e999999999` stands
    for would fill the memory.
    """
    if len(text) > MOST_DIGITS or _EXACT.fullmatch(text) is None:
        raise ValueError(text)
    parts = [Decimal(part) for part in text.split("/", 1)]
    if not all(part.is_finite() and abs(part.adjusted()) <= MOST_DIGITS for part in parts):
        raise ValueError(text)
    return Fraction(parts[0]) / (Fraction(parts[1]) if len(parts) > 1 else 1)


def certify_start(
    board: Board, seed: int | None, x: Fraction, effort: Effort = FULL
) -> Certificate:
    """`certify` of a parsed seed and start."""
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
    """Follow the balls from all starts within `radius` of x, in m; double the bits until decided.

    A path that reaches MAX_EVENTS is undecided at once: more bits would not shorten it.
    """
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
            why = f"where the ball goes after the first {MAX_EVENTS} events"
            return Outcome(None, proof, bits, why)
        except UndecidedError as error:
            if clock() >= until:
                why = f"{error.what}: undecided after {effort.seconds:g} s, at {bits} bits"
                return Outcome(None, proof, bits, why)
            if error.is_final or 2 * bits > effort.most_bits:
                return Outcome(None, proof, bits, f"{error.what}: undecided at {bits} bits")
        bits *= 2


def _start(x: Fraction, radius: Fraction) -> arb:
    middle = arb(fmpq(x.numerator, x.denominator))
    return middle + arb(0, arb(fmpq(radius.numerator, radius.denominator)))
